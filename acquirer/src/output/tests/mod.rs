//! What lies in the results folder, read back the way another program would.

mod fixture;

mod files;

mod drawing;

mod relief;

mod report;
