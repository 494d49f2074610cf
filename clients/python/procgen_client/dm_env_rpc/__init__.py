"""procgen-dm-env-rpc: serves worlds to agents that speak dm_env_rpc; see README.md."""
