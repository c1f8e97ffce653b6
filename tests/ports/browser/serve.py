"""Between the checker and tracer.html: raytruth's protocol on one side, a headless browser on the other.

    raytruth check-port -- python serve.py [BROWSER]

The page asks this program for scenes over http on a port of the loopback device and posts what it drew.
"""

import json
import os
import queue
import subprocess
import sys
import tempfile
import threading
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path

PAGE = Path(__file__).with_name("tracer.html").read_bytes()
FLAGS = ("--headless", "--no-sandbox", "--disable-gpu-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader",
         "--disable-dev-shm-usage", "--no-first-run", "--disable-background-networking", "--js-flags=--max-old-space-size=256")
scenes, answers = queue.Queue(), queue.Queue()


class Handler(BaseHTTPRequestHandler):
    def do_GET(self):
        body, kind = (PAGE, "text/html") if self.path == "/" else (scenes.get() if self.path == "/next" else b"", "text/plain")
        self.send_response(200 if self.path in ("/", "/next") else 404)
        self.send_header("Content-Type", kind)
        self.send_header("Content-Length", str(len(body)))
        self.end_headers()
        self.wfile.write(body)

    def do_POST(self):
        answers.put(self.rfile.read(int(self.headers["Content-Length"])))
        self.send_response(204)
        self.end_headers()

    def log_message(self, *_):
        pass


def answer(seq: int, text: bytes) -> tuple[dict, bytes]:
    scenes.put(text)
    drawn = answers.get()
    if drawn.startswith(b"unsupported: "):
        return {"seq": seq, "state": "unsupported", "message": drawn.decode()[13:200]}, b""
    import array

    floats = array.array("f", drawn)
    half, lines = len(floats) // 2, text.decode().splitlines()
    rays = sum(line.startswith("ray ") for line in lines)
    width, height = map(int, next(line for line in lines if line.startswith("camera ")).split()[-2:])
    shape = [rays] if rays else [height, width]
    three = lambda start: array.array("f", (v for k in range(start, start + half, 4) for v in floats[k:k + 3]))
    index = array.array("i", (int(floats[k]) for k in range(3, half, 4)))
    t = array.array("f", (v if v < 1e29 else float("inf") for v in floats[half + 3::4]))
    blocks = [("color", "float32", [*shape, 3], three(0)), ("index", "int32", shape, index), ("t", "float32", shape, t),
              ("normal", "float32", [*shape, 3], three(half))]
    body = b"".join(block.tobytes() for *_, block in blocks)
    return {"seq": seq, "state": "ok", "bytes": len(body),
            "arrays": [{"name": name, "dtype": dtype, "shape": shape} for name, dtype, shape, _ in blocks]}, body


def main():
    server = ThreadingHTTPServer(("127.0.0.1", 0), Handler)
    threading.Thread(target=server.serve_forever, daemon=True).start()
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as profile:
        browser = subprocess.Popen([sys.argv[1] if len(sys.argv) > 1 else "chromium", *FLAGS, f"--user-data-dir={profile}",
                                    f"http://127.0.0.1:{server.server_port}/"],
                                   stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        for line in sys.stdin.buffer:
            request = json.loads(line)
            if request["op"] == "hello":
                head, body = {"protocol": 1, "name": "raytruth browser example", "levels": ["model"], "precision": 32,
                              "switches": ["E1", "F1", "F2", "F3", "F4", "F5"]}, b""
            else:
                head, body = answer(request["seq"], sys.stdin.buffer.read(request["bytes"]))
            sys.stdout.buffer.write(json.dumps(head).encode() + b"\n" + body)
            sys.stdout.buffer.flush()
        browser.terminate()
    os._exit(0)


if __name__ == "__main__":
    main()
