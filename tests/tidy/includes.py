"""The dependency table: which folder may include, link and use which."""

import posixpath
import re

from source_tree import Violation

# Module: the modules that it may include, besides itself. A module is the longest folder here that
# holds the file. Read it as a map: state <- random <- world <- level <- scene <- {games,
# render} <- environment <- pool, over any number of steps; render and games do not know each other;
# the server knows the engine by envcore/pool alone. The C++ client is pools in this process or on a
# server; the C ABI, libenv, top and the Python client's native module are over it. Another client
# knows the contract alone.
_BELOW_SCENE = ("envcore/status", "envcore/state", "envcore/random", "envcore/world",
                "envcore/level")
_BELOW_POOL = ("envcore/pool", "server/concurrency", "server/encoding", "server/metrics")
_POOL = {
    "server/pool/quota": ("server/concurrency",),
    "server/pool/episodes": ("envcore/pool", "server/pool/quota"),
    "server/pool": (*_BELOW_POOL, "server/logging", "server/pool/episodes", "server/pool/quota"),
    "server/pool/watch": (*_BELOW_POOL, "server/pool"),
}
_BELOW_FRONTS = ("server/concurrency", "server/logging", "server/wire", "proto")
# gRPC's types, the door; then the stream, watching and the services.
_BELOW_RPC = ("envcore/pool", *_BELOW_FRONTS, *_POOL, "server/cluster", "server/encoding",
              "server/metrics", "server/net")
_RPC = {
    "server/rpc/grpc": ("proto",),
    "server/rpc/auth": ("server/logging", "server/metrics", "server/net", "server/rpc/grpc",
                        "server/pool/quota"),
}
for _folder in ("run", "watch", "services"):
    _RPC[f"server/rpc/{_folder}"] = (*_BELOW_RPC, *_RPC)
_RPC["server/rpc"] = (*_BELOW_RPC, *_RPC)
# Down from a connection to what is played; each knows those above it.
_BELOW_WEB = ("envcore/pool", "envcore/environment", "envcore/trace", "envcore/games",
              *_BELOW_FRONTS, "server/encoding", "server/net", "clients/cpp")
_WEB = {"server/web/json": _BELOW_WEB}
for _folder in ("/play", "/session", "/http", ""):
    _WEB[f"server/web{_folder}"] = (*_BELOW_WEB, *_WEB)
# The bytes of a frame, the shapes, the pictures, the scene.
_RENDER = {"envcore/render/output": _BELOW_SCENE}
for _folder in ("raster", "art", "scene"):
    _RENDER[f"envcore/render/{_folder}"] = (*_BELOW_SCENE, "envcore/scene", "envcore/art", *_RENDER)
_BELOW_ENVIRONMENT = (*_BELOW_SCENE, "envcore/scene", "envcore/games", *_RENDER, "envcore/art")
ARROWS = {
    "envcore/status": (),
    "envcore/state": ("envcore/status",),
    "envcore/random": ("envcore/status", "envcore/state"),
    "envcore/world": ("envcore/status", "envcore/state", "envcore/random"),
    "envcore/level": ("envcore/status", "envcore/state", "envcore/random", "envcore/world"),
    "envcore/scene": _BELOW_SCENE,
    "envcore/games": (*_BELOW_SCENE, "envcore/scene"),
    "envcore/art": (),
    **_RENDER,
    "envcore/environment": _BELOW_ENVIRONMENT,
    "envcore/pool": (*_BELOW_ENVIRONMENT, "envcore/environment"),
    "envcore/trace": (*_BELOW_ENVIRONMENT, "envcore/environment"),
    "proto": (),
    # How threads start and wait, for all folders of the server, and what is logged.
    "server/concurrency": (),
    "server/logging": ("server/concurrency",),
    "server/cluster": ("server/concurrency",),
    "server/encoding": (),
    "server/metrics": (),
    "server/net": ("server/concurrency", "server/logging"),
    **_POOL,
    "server/wire": ("envcore/pool", "server/cluster", "server/encoding", *_POOL,
                    "proto"),
    **_RPC,
    # A client of the very server that it lives in, so it knows clients/cpp.
    **_WEB,
    # The program itself: flags, wiring, signals, shutdown.
    "server": ("envcore/pool", *_BELOW_FRONTS, *_POOL, "server/rpc", "server/rpc/auth",
               "server/rpc/services", "server/net", "server/metrics",
               "server/cluster", "server/web"),
    "clients/cpp": ("proto", "envcore/status", "envcore/environment", "envcore/pool"),
    "clients/c": ("envcore/status", "envcore/environment", "envcore/games", "envcore/pool",
                  "clients/cpp"),
    "clients/libenv": ("proto", "envcore/pool", "clients/cpp"),
    "clients": ("proto",),
    # Programs for people, over the engine or over a server.
    "tools": (*_BELOW_ENVIRONMENT, "envcore/environment", "envcore/pool", "envcore/trace", "proto",
              "clients/cpp"),
}
# Folders whose files may include anything.
_FREE = ("tests",)

# Headers that only some folders may include: pattern, folders, what to do.
_GUARDED_HEADERS = (
    (r"grpc(pp)?/|.*\.grpc\.pb\.h$", ("server/rpc", "clients", "tests"),
     "only server/rpc and the clients speak gRPC; put the call behind an interface of this module"),
    (r".*\.pb\.h$",
     ("server/rpc", "server/wire", "server/web", "clients", "tests"),
     "messages of the wire stop at server/wire; convert them there to a type of this module"),
    (r"(.*/)?dds/|(.*/)?dds\.h$|server/cluster/topics\.h$", ("server/cluster", "tests"),
     "only server/cluster knows Cyclone DDS"),
    (r"boost/", ("server/web", "tests"),
     "only server/web knows Boost, for HTTP and WebSocket"),
    (r"prometheus/", ("server/metrics", "tests"),
     "only server/metrics knows Prometheus; count what you do with class Metrics"),
)
# What the engine never includes, and where threads are allowed in it.
_CLOCKS_AND_SOCKETS = re.compile(
    r"(chrono|ctime|time\.h|absl/time/.*|sys/socket\.h|netinet/.*|unistd\.h)$")
_THREADS = re.compile(r"(thread|future|condition_variable|pthread\.h)$")

# Libraries that are installed have an include folder of their own: their headers are included, and
# guarded, by the path from there.
INCLUDE_ROOTS = ("clients/cpp/",)

_INCLUDE = re.compile(r'\s*#\s*include\s*[<"]([^">]+)[">]')


def includes_of(tree, path):
    """Yields (line number, path) of what a C++ file includes."""
    for number, line in tree.lines(path):
        match = _INCLUDE.match(line)
        if match:
            yield number, _from_root(tree, match.group(1))


def _from_root(tree, included):
    """The path of an included file of ours from the root of the repository."""
    paths = (root + included for root in INCLUDE_ROOTS)
    return next((path for path in paths if path in tree), included)


def cpp_files(tree):
    return tree.with_suffix(".h", ".cc")


def module_of(path):
    """The module that a file of ours belongs to, '' if it is in none."""
    folder = posixpath.dirname(path)
    while folder and folder not in ARROWS:
        folder = posixpath.dirname(folder)
    return folder


def _is_under(path, folders):
    return any(path == folder or path.startswith(folder + "/") for folder in folders)


def _may_use(source_path, target_path):
    source, target = module_of(source_path), module_of(target_path)
    if target in ARROWS[source]:
        return True
    if source != target:
        return False
    # The clients form one module here, but each knows only itself.
    same_client = source_path.split("/")[:2] == target_path.split("/")[:2]
    return source != "clients" or same_client


def check_include_arrows(tree):
    """An include follows an arrow of the table."""
    for path in cpp_files(tree):
        if _is_under(path, _FREE):
            continue
        source = module_of(path)
        if not source:
            yield Violation(path, 1, "this folder is in no module; add it to ARROWS in "
                                     "tests/tidy/includes.py with the modules that it may include")
            continue
        for number, included in includes_of(tree, path):
            if _is_under(included, _FREE):
                yield Violation(path, number, f"{source} includes {included}: nothing but a test "
                                              "includes what is under tests")
            elif module_of(included) and not _may_use(path, included):
                allowed = ", ".join(ARROWS[source]) or "nothing else of ours"
                yield Violation(path, number,
                                f"{source} must not include {included}; it may include {allowed}")


def check_guarded_headers(tree):
    """gRPC, generated messages and DDS stay behind their borders."""
    for path in cpp_files(tree):
        for number, included in includes_of(tree, path):
            for pattern, folders, advice in _GUARDED_HEADERS:
                if re.match(pattern, included) and not _is_under(path, folders):
                    yield Violation(path, number, f"includes {included}: {advice}")
                    break


def check_engine_purity(tree):
    """envcore has no clocks and no sockets, and threads only in envcore/pool."""
    for path in cpp_files(tree):
        if not _is_under(path, ("envcore",)):
            continue
        for number, included in includes_of(tree, path):
            if _CLOCKS_AND_SOCKETS.match(included):
                yield Violation(path, number, f"includes <{included}>: the engine knows no clock "
                                              "and no socket; give it what it needs as a value")
            elif _THREADS.match(included) and not _is_under(path, ("envcore/pool",)):
                yield Violation(path, number, f"includes <{included}>: in the engine only "
                                              "envcore/pool has threads")


_LINK = re.compile(r"target_link_libraries\s*\(([^)]*)\)")
_TARGET = re.compile(r"procgen::(\w+)")
_ENGINE_TARGETS = ("state", "random", "world", "level", "scene", "games", "art", "render",
                   "environment", "pool", "trace")


def check_link_arrows(tree):
    """The direction of linking is the direction of includes, also for the clients."""
    for path in tree.with_suffix("CMakeLists.txt"):
        folder = posixpath.dirname(path)
        module = module_of(path)
        if not module or _is_under(path, _FREE):
            continue
        text = tree.text(path)
        for link in _LINK.finditer(text):
            number = text.count("\n", 0, link.start()) + 1
            for name in _TARGET.findall(link.group(1)):
                target = f"envcore/{name}"
                if name in _ENGINE_TARGETS and not any(
                        _is_under(allowed, (target,)) for allowed in (folder, *ARROWS[module])):
                    yield Violation(path, number, f"{module} must not link procgen::{name}; "
                                                  f"see ARROWS in tests/tidy/includes.py")


RULES = (check_include_arrows, check_guarded_headers, check_engine_purity, check_link_arrows)
