"""The dependency table: which folders a folder may include and link."""

import posixpath
import re

from source_tree import Violation

# DEPENDENCIES: for each module, the other modules that it may include. A file's module is the
# longest of these folders that contains it. In the engine:
#     status <- state <- random <- world <- level <- scene <- {games, render} <- environment <- pool
# The server uses the engine through envcore/pool. clients/c and clients/libenv use clients/cpp.
_BELOW_SCENE = ("envcore/status", "envcore/state", "envcore/random", "envcore/world",
                "envcore/level")
_BELOW_POOL = ("envcore/pool", "server/concurrency", "server/encoding", "server/metrics")
_POOL = {
    "server/pool/quota": ("server/concurrency",),
    "server/pool/episodes": ("envcore/pool", "server/pool/quota"),
    "server/pool/history": ("server/concurrency",),
    "server/pool": (*_BELOW_POOL, "server/logging", "server/pool/episodes", "server/pool/history",
                    "server/pool/quota"),
    "server/pool/watch": (*_BELOW_POOL, "server/pool", "server/pool/episodes"),
}
_BELOW_SERVICES = ("server/concurrency", "server/logging", "server/wire", "proto")
_BELOW_RPC = ("envcore/pool", *_BELOW_SERVICES, *_POOL, "server/cluster", "server/encoding",
              "server/metrics", "server/net")
_RPC = {
    "server/rpc/grpc": ("proto",),
    "server/rpc/auth": ("server/logging", "server/metrics", "server/net", "server/rpc/grpc",
                        "server/pool/quota"),
}
_RPC["server/rpc/bridge"] = ()
for _folder in ("pause", "run", "watch", "services"):
    _RPC[f"server/rpc/{_folder}"] = (*_BELOW_RPC, *_RPC)
_RPC["server/rpc"] = (*_BELOW_RPC, *_RPC)
_BELOW_WEB = ("server/concurrency", "server/net", "server/rpc/bridge", "proto")
_WEB = {
    "server/web/bridge": ("proto", "server/rpc/bridge"),
    "server/web/http": (*_BELOW_WEB, "server/web/bridge"),
    "server/web": (*_BELOW_WEB, "server/web/bridge", "server/web/http"),
}
# Each folder may include the ones before it.
_RENDER = {"envcore/render/output": _BELOW_SCENE}
for _folder in ("raster", "art", "scene"):
    _RENDER[f"envcore/render/{_folder}"] = (*_BELOW_SCENE, "envcore/scene", "envcore/art", *_RENDER)
_BELOW_ENVIRONMENT = (*_BELOW_SCENE, "envcore/scene", "envcore/games", *_RENDER, "envcore/art")
DEPENDENCIES = {
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
    "proto": ("envcore/pool",),
    "server/concurrency": (),
    "server/logging": ("server/concurrency",),
    "server/cluster": ("server/concurrency", "server/logging"),
    "server/encoding": (),
    "server/metrics": (),
    "server/net": ("server/concurrency", "server/logging"),
    **_POOL,
    "server/wire": ("envcore/pool", "server/cluster", "server/encoding", *_POOL,
                    "proto"),
    **_RPC,
    **_WEB,
    "server": ("envcore/pool", *_BELOW_SERVICES, *_POOL, "server/rpc", "server/rpc/auth",
               "server/rpc/services", "server/net", "server/metrics",
               "server/cluster", "server/web"),
    "clients/cpp": ("proto", "envcore/status", "envcore/environment", "envcore/pool"),
    "clients/c": ("envcore/status", "envcore/environment", "envcore/games", "envcore/pool",
                  "clients/cpp"),
    "clients/libenv": ("proto", "envcore/pool", "clients/cpp"),
    "clients": ("proto",),
    "tools": (*_BELOW_ENVIRONMENT, "envcore/environment", "envcore/pool", "envcore/trace", "proto",
              "clients/cpp"),
}
# Folders whose files may include anything.
_UNRESTRICTED = ("tests",)

# Headers that only some folders may include: pattern, folders, what to do.
_GUARDED_HEADERS = (
    (r"grpc(pp)?/|.*\.grpc\.pb\.h$", ("server/rpc", "clients", "tests"),
     "only server/rpc and the clients use gRPC; call it through an interface of this module"),
    (r".*\.pb\.h$",
     ("proto", "server/rpc", "server/wire", "server/web", "clients", "tests"),
     "proto and server/wire convert messages to types of this module"),
    (r"(.*/)?dds/|(.*/)?dds\.h$|server/cluster/topics\.h$", ("server/cluster", "tests"),
     "only server/cluster uses Cyclone DDS"),
    (r"boost/", ("server/web", "tests"),
     "only server/web uses Boost, for HTTP and WebSocket"),
    (r"prometheus/", ("server/metrics", "tests"),
     "only server/metrics uses prometheus-cpp; count with class Metrics"),
)
# Headers that the engine must not include; threads are allowed in envcore/pool.
_CLOCKS_AND_SOCKETS = re.compile(
    r"(chrono|ctime|time\.h|absl/time/.*|sys/socket\.h|netinet/.*|unistd\.h)$")
_THREADS = re.compile(r"(thread|future|condition_variable|pthread\.h)$")

# Include folders of installed libraries: includes and include guards are relative to them.
INCLUDE_ROOTS = ("clients/cpp/",)

_INCLUDE = re.compile(r'\s*#\s*include\s*[<"]([^">]+)[">]')


def includes_of(tree, path):
    """Yields (line number, path) of what a C++ file includes."""
    for number, line in tree.lines(path):
        match = _INCLUDE.match(line)
        if match:
            yield number, _from_root(tree, match.group(1))


def _from_root(tree, included):
    """Returns the path, from the root of the repository, of an included file."""
    paths = (root + included for root in INCLUDE_ROOTS)
    return next((path for path in paths if path in tree), included)


def cpp_files(tree):
    return tree.with_suffix(".h", ".cc")


def module_of(path):
    """Returns the module of a file, '' if it is in none."""
    folder = posixpath.dirname(path)
    while folder and folder not in DEPENDENCIES:
        folder = posixpath.dirname(folder)
    return folder


def _is_under(path, folders):
    return any(path == folder or path.startswith(folder + "/") for folder in folders)


def _may_use(source_path, target_path):
    source, target = module_of(source_path), module_of(target_path)
    if target in DEPENDENCIES[source]:
        return True
    if source != target:
        return False
    # The other clients form one module, but must not include each other.
    same_client = source_path.split("/")[:2] == target_path.split("/")[:2]
    return source != "clients" or same_client


def check_include_directions(tree):
    """DEPENDENCIES allows every include."""
    for path in cpp_files(tree):
        if _is_under(path, _UNRESTRICTED):
            continue
        source = module_of(path)
        if not source:
            yield Violation(path, 1, "this folder is in no module; add it to DEPENDENCIES in "
                                     "tests/tidy/includes.py")
            continue
        for number, included in includes_of(tree, path):
            if _is_under(included, _UNRESTRICTED):
                yield Violation(path, number, f"{source} includes {included}: only tests may "
                                              "include files of tests")
            elif module_of(included) and not _may_use(path, included):
                allowed = ", ".join(DEPENDENCIES[source]) or "no other module"
                yield Violation(path, number,
                                f"{source} must not include {included}; it may include {allowed}")


def check_guarded_headers(tree):
    """Only the folders of _GUARDED_HEADERS include gRPC, messages, DDS and other libraries."""
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
                yield Violation(path, number, f"includes <{included}>: the engine must not use "
                                              "clocks and sockets; pass values instead")
            elif _THREADS.match(included) and not _is_under(path, ("envcore/pool",)):
                yield Violation(path, number, f"includes <{included}>: in the engine only "
                                              "envcore/pool has threads")


_LINK = re.compile(r"target_link_libraries\s*\(([^)]*)\)")
_TARGET = re.compile(r"procgen::(\w+)")
_ENGINE_TARGETS = ("state", "random", "world", "level", "scene", "games", "art", "render",
                   "environment", "pool", "trace")


def check_link_directions(tree):
    """DEPENDENCIES allows every link between targets of the engine, clients and server."""
    for path in tree.with_suffix("CMakeLists.txt"):
        folder = posixpath.dirname(path)
        module = module_of(path)
        if not module or _is_under(path, _UNRESTRICTED):
            continue
        text = tree.text(path)
        for link in _LINK.finditer(text):
            number = text.count("\n", 0, link.start()) + 1
            allowed = (folder, *DEPENDENCIES[module])
            for name in _TARGET.findall(link.group(1)):
                target = f"envcore/{name}"
                if name in _ENGINE_TARGETS and not any(
                        _is_under(other, (target,)) for other in allowed):
                    yield Violation(path, number, f"{module} must not link procgen::{name}; "
                                                  f"see DEPENDENCIES in tests/tidy/includes.py")


RULES = (check_include_directions, check_guarded_headers, check_engine_purity,
         check_link_directions)
