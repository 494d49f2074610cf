"""All exceptions from the rules, each with its reason.

An entry is (rule, path, reason); '*' in the path matches anything. An entry whose path exists but
matches no violation is reported.
"""

EXCEPTIONS = (
    ("check_readmes", "deploy/kubernetes/*",
     "deploy/kubernetes/README.md is the guide to the base and its overlays"),
    ("check_readmes", "clients/examples/*", "clients/examples/README.md describes all languages"),
    ("check_readmes", "proto/*", "proto/README.md is the guide to the contract, for all versions"),
    ("check_readmes", "clients/cpp/procgen_client/README.md",
     "the library's guide is clients/cpp/README.md, one folder up"),
    ("check_readmes", "clients/python/procgen_package/procgen/README.md",
     "the package's README.md is one folder up, where pip reads it"),
)
