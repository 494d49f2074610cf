"""The exceptions from the rules: all of them, each with its reason.

An entry is (rule, path, reason); the path may have '*' for anything. An entry that excuses nothing
although its path exists is itself reported, so that the list stays as short as it can be.
"""

EXCEPTIONS = (
    ("check_readmes", "deploy/kubernetes/*",
     "deploy/kubernetes/README.md is the guide to the base and its overlays"),
    ("check_readmes", "proto/*", "proto/README.md is the guide to the contract, for all versions"),
    ("check_readmes", "clients/cpp/procgen_client/README.md",
     "the library's guide is clients/cpp/README.md, one folder up"),
    ("check_readmes", "clients/python/procgen_client/README.md",
     "the package's guide is clients/python/README.md, one folder up"),
)
