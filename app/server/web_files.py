"""What the lab's page has beside viser's: scripts and styles of its own, below `/web/`.

viser has one page, a single file. `first.js` is put into it, before viser's own script; the other
files of `app/web` are served as they are, and the page loads `lab.js` and the styles. All
addresses are relative to the page, so they hold below a path as well. Some folders are the page of
a frame (`channels`), with what it alone loads; `player` has what such pages share.
"""

import functools
import gzip
import re
from http import HTTPStatus
from pathlib import Path
from typing import Final, Literal, get_args

from websockets.datastructures import Headers
from websockets.http11 import Request, Response

from app.util.html import escaped
from app.words.glossary import table_html

_FOLDER: Final = Path(__file__).resolve().parent.parent / "web"
_TYPES: Final = {".js": "text/javascript; charset=utf-8", ".css": "text/css; charset=utf-8"}
_IMPORTED: Final = re.compile(
    r"""^import\s(?:[^"';]*\sfrom\s+)?"(\.{1,2}/[\w./-]+\.js)";""", re.MULTILINE
)
"""What a module needs before it can run, relative to itself."""
_STYLES: Final = re.compile(r'<link rel="stylesheet" href="web/([\w./-]+)" />')
Frame = Literal["time", "side", "lesson"]
FRAMES: Final[tuple[Frame, ...]] = get_args(Frame)
"""Folders that are the page of a frame: an ``index.html``, and ``frame.js``, which begins it."""
_PAGES: Final = frozenset({"/", "/index.html"})
_TITLE: Final = b"<title>Viser</title>"
"""Where our scripts go in viser's page: ahead of its own."""


def path_of(request: Request) -> str:
    """The path that is asked for, without the question."""
    return request.path.partition("?")[0]


def is_page(request: Request) -> bool:
    return path_of(request) in _PAGES


@functools.cache
def _files() -> dict[str, Path]:
    return {
        f"/web/{file.relative_to(_FOLDER).as_posix()}": file
        for file in _FOLDER.rglob("*")
        if file.suffix in _TYPES
    }


def is_own_file(request: Request) -> bool:
    return path_of(request) in _files()


def own_file(request: Request) -> Response:
    """One of the page's own files."""
    file = _files()[path_of(request)]
    headers = Headers({"Content-Type": _TYPES[file.suffix], "Cache-Control": "no-cache"})
    return response(file.read_bytes(), headers)


@functools.cache
def frame_document(page: Frame) -> bytes:
    """The page of a frame: it asks for all of its scripts at once, not for one after another as
    each is found to need the next."""
    folder = _FOLDER / page
    links = "".join(
        f'<link rel="modulepreload" href="../../web/{path.relative_to(_FOLDER).as_posix()}" />\n'
        for path in modules_of(folder / "frame.js")
    )
    return (folder / "index.html").read_text("utf-8").replace("</head>", f"{links}</head>").encode()


def modules_of(script: Path) -> list[Path]:
    """A script of the page and all that it imports, directly or not, each before who needs it."""
    found: list[Path] = []
    _find(script.resolve(), found, set())
    return found


def _find(script: Path, found: list[Path], seen: set[Path]) -> None:
    if script in seen:
        return
    seen.add(script)
    for name in _IMPORTED.findall(script.read_text("utf-8")):
        _find((script.parent / name).resolve(), found, seen)
    found.append(script)


def response(body: bytes, headers: Headers, status: HTTPStatus = HTTPStatus.OK) -> Response:
    headers["Connection"] = "close"
    headers["Content-Length"] = str(len(body))
    return Response(status.value, status.phrase, headers, body)


def dress(page: Response, title: str) -> Response:
    """viser's page with our additions; a page that is not viser's is left as it is."""
    if page.status_code == HTTPStatus.OK:
        is_packed = page.headers.get("Content-Encoding") == "gzip"
        page.body = _dressed(bytes(page.body), is_packed, title)
        del page.headers["Content-Length"]
        page.headers["Content-Length"] = str(len(page.body))
    return page


@functools.lru_cache(maxsize=4)
def _dressed(body: bytes, is_packed: bool, title: str) -> bytes:
    head = (
        f"<title>{escaped(title)}</title>\n"
        f"<script>\n{(_FOLDER / 'first.js').read_text('utf-8')}</script>\n"
        '<link rel="stylesheet" href="web/lab.css" />\n'
        '<link rel="stylesheet" href="web/looks.css" />\n'
        '<link rel="stylesheet" href="web/stage.css" />\n'
        '<link rel="stylesheet" href="web/controls.css" />\n'
        '<link rel="stylesheet" href="web/frame.css" />\n'
        '<link rel="stylesheet" href="web/side.css" />\n'
        '<link rel="stylesheet" href="web/lesson.css" />\n'
        '<link rel="stylesheet" href="web/readings.css" />\n'
        '<link rel="stylesheet" href="web/hunts.css" />\n'
        '<link rel="stylesheet" href="web/terms.css" />\n'
        '<link rel="stylesheet" href="web/tour.css" />\n'
        '<script type="module" src="web/lab.js"></script>'
    )
    text = gzip.decompress(body) if is_packed else body
    dressed = text.replace(_TITLE, head.encode(), 1)
    return gzip.compress(dressed) if is_packed else dressed


@functools.cache
def _audience_files() -> dict[str, tuple[bytes, str]]:
    """What the page of an audience is and loads, by its path: content and type. There is nothing
    else."""
    folder = _FOLDER / "audience"
    page = (folder / "index.html").read_text("utf-8")
    scripts = modules_of(folder / "audience.js")
    files = [*scripts, *(_FOLDER / name for name in _STYLES.findall(page))]
    paths = {f"/web/{file.relative_to(_FOLDER).as_posix()}": file for file in files}
    links = "".join(
        f'<link rel="modulepreload" href="{path.removeprefix("/")}" />\n'
        for path, file in paths.items()
        if file in scripts
    )
    # What words mean that are explained (`terms.js`).
    page = page.replace("</body>", f"{table_html()}</body>")
    document = page.replace("</head>", f"{links}</head>").encode()
    return {
        **{path: (file.read_bytes(), _TYPES[file.suffix]) for path, file in paths.items()},
        **dict.fromkeys(_PAGES, (document, "text/html; charset=utf-8")),
    }


def audience_file(request: Request) -> Response | None:
    """The page of an audience, or one of the files that it loads; None if it is neither."""
    found = _audience_files().get(path_of(request))
    if found is None:
        return None
    body, kind = found
    return response(body, Headers({"Content-Type": kind, "Cache-Control": "no-cache"}))
