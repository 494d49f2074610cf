"""Programs and helpers around a pool: a server of one's own, evaluation, statistics, videos."""
