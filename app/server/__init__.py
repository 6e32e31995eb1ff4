"""The lab's web server: viser's, behind a door.

viser serves a page and a websocket to anyone who can reach the port: it looks neither at the `Host`
nor at the `Origin` of a request, and it stores whatever a page sends as a widget's value.
`open_server` puts a door in front of it, at four places:

- *the connection* (`connections`): those that have not said what they want are few and short;
- *the request* (`door`, `origin`, `access`): `Host` must be a name of this server (a foreign name
  that resolves to it is DNS rebinding), a page must come from this very server or from a place that
  its owner declared, on the network it must bring a token, and there is a limit on open pages;
- *the frame* (`shapes`): what is not a viser message ends its connection, quietly; what has a wrong
  shape is dropped, before viser's decoder can make anything of it;
- *the message* (`admission`, `values`): only what a page has reason to send, for a widget that is
  there, shown and enabled, with a value that this very widget allows. All else is dropped before
  viser sees it.

What a page may cost is bounded as well: how fast its messages are acted on (`pace`), how many of
its callbacks run (`workers`), how much waits to be sent to it (`outbox`) and what it is told
(`notices`). What many browsers see alike is drawn and packed once (`stage`), and sent to each as
fast as it takes it in (`pulse`).

The page that it serves is viser's with scripts of our own in it (`web_files`, `app/web`), which
among other things say in words why there is no connection (`refusals`).

The door is also a way back out of HTML (`calls`), which viser does not have.

Private parts of viser are used in this package alone (viser>=1.1.1,<1.2). It replaces viser's pool
of threads, and one function while a server is being made: `websockets.asyncio.server.serve`, since
viser passes its request handler and size limit through that call, and offers no other way in.
"""
