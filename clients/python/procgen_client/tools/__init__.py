"""Local servers, evaluation, episode statistics, videos."""
