"""Browsers that read every frame and draw nothing: ``python -m benchmarks.page_client PORT N``.

They run in a process of their own, so that what is measured is the page and not its readers.
"""

import sys
import threading

import msgspec.msgpack
import viser
from viser import _messages as wire
from websockets.sync.client import connect

_CAMERA = wire.ViewerCameraMessage(
    wxyz=(1.0, 0.0, 0.0, 0.0),
    position=(0.0, 0.0, 10.0),
    fov=1.0,
    near=0.01,
    far=1000.0,
    image_height=768,
    image_width=1366,
    look_at=(0.0, 0.0, 0.0),
    up_direction=(0.0, 1.0, 0.0),
)
"""A browser counts as connected once it has said where its camera is."""


def read_for_ever(port: int) -> None:
    """Connect as a browser does, and take in whatever comes."""
    with connect(
        f"ws://127.0.0.1:{port}",
        subprotocols=[f"viser-v{viser.__version__}"],  # pyright: ignore[reportArgumentType]
        max_size=None,
        compression=None,
        # This machine is reached directly, whatever proxy the environment names for the rest.
        proxy=None,
    ) as connection:
        connection.send(msgspec.msgpack.encode(_CAMERA.as_serializable_dict()))
        for _ in connection:
            pass


def main() -> None:
    """Read until killed."""
    port, n_clients = int(sys.argv[1]), int(sys.argv[2])
    for _ in range(n_clients):
        threading.Thread(target=read_for_ever, args=(port,), daemon=True).start()
    sys.stdin.read()


if __name__ == "__main__":
    main()
