#!/usr/bin/env python3
"""A projector's client in Python's standard library alone, written from PROTOCOL.md.

client.py pair CODE [HOST:PORT]                 pairs, prints the token that is ours from then on
client.py grid HOST:PORT FINGERPRINT TOKEN      shows a grid of 31 lines, prints the projector's state as JSON

Exit code 0, or 1 with the projector's message on standard error.
"""

import hashlib
import json
import socket
import ssl
import sys


class Projector:
    """A connection: TLS with a projector whose certificate is known by its fingerprint."""

    def __init__(self, address, fingerprint, token, role="controller"):
        host, port = address.rsplit(":", 1)
        context = ssl.SSLContext(ssl.PROTOCOL_TLS_CLIENT)
        context.minimum_version = ssl.TLSVersion.TLSv1_3
        context.check_hostname = False  # the fingerprint says it all
        context.verify_mode = ssl.CERT_NONE
        tcp = socket.create_connection((host, int(port)), timeout=30)
        self.socket = context.wrap_socket(tcp)
        certificate = self.socket.getpeercert(binary_form=True)
        if hashlib.sha256(certificate).hexdigest() != fingerprint.lower():
            raise SystemExit("another certificate than the paired one: nothing was said to it")
        self.lines = self.socket.makefile("r", encoding="utf-8", newline="\n")
        self.last_id = 0
        self.new_token = None
        hello = {"type": "hello", "version": 1, "role": role, "name": "python", "token": token}
        self.send(hello)
        while True:
            message = self.receive()
            if message["type"] == "paired":
                self.new_token = message["token"]
            elif message["type"] == "welcome":
                return

    def send(self, message):
        self.socket.sendall(json.dumps(message).encode() + b"\n")

    def receive(self):
        line = self.lines.readline()
        if not line:
            raise SystemExit("the projector closed the connection")
        message = json.loads(line)
        if message["type"] == "error":
            raise SystemExit(f"{message['code']}: {message['message']}")
        return message

    def ask(self, **request):
        """Sends a request and gives its reply; notices between are passed over."""
        self.last_id += 1
        self.send({"id": self.last_id, **request})
        while True:
            message = self.receive()
            if message.get("id") == self.last_id:
                return message


def pair(code, address=None):
    _, code_address, fingerprint, token = code.split("/")
    print(Projector(address or code_address, fingerprint, token.lower()).new_token)


def grid(address, fingerprint, token):
    projector = Projector(address, fingerprint, token)
    view = {"kind": "grid", "rows": 31, "columns": 31, "row_width_px": 4, "column_width_px": 4,
            "colours": ["#ff0000", "#ffff00", "#ff00ff", "#00ff00"]}
    projector.ask(type="show", view=view)
    print(json.dumps(projector.ask(type="state")["state"]))


if __name__ == "__main__":
    commands = {"pair": pair, "grid": grid}
    if len(sys.argv) < 3 or sys.argv[1] not in commands:
        raise SystemExit(__doc__)
    commands[sys.argv[1]](*sys.argv[2:])
