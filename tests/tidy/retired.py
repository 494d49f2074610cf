"""Retired names must not be used again."""

import re

from source_tree import Violation

# Retired name: its replacement. A name counts in every case style, in the plural and as a part of
# longer names: `side_px` also as sidePx, kSidePxMax and SIDE_PX. Write the replacement in the style
# of its place.
WORDS = {
    # The contract, flags, metrics, log events and clients.
    "answering_node": "local_node",
    "asks_token": "requires_token",
    "benchmark_contestant": "procgen-benchmark-worker",
    "environment_count": "env_count",
    "episode_end": "AutoresetMode",
    "first_environment": "first_env",
    "follows_another": "prev_level_incomplete",
    "hold_options": "PoolOptions",
    "incomplete_because": "incomplete_reason",
    "later_level": "LevelChange",
    "of_channel": "FromChannel",
    "pools_ended": "pools_closed",
    "private_server": "local_server",
    "procgen_search": "procgen-solve",
    "random_returns": "procgen-random-baseline",
    "response_count_min": "chunk_count",
    "secrets_open_to_all": "token_file_world_readable",
    "shard_goes_on": "shard_resumed",
    "side_px": "size_px",
    "total_environments": "total_env_count",
    "web_hosts": "--web_allowed_hosts",
    "which_episode": "EpisodeSelector",
    "zstd_difference": "ENCODING_DELTA_ZSTD",
    # Inside the engine and the server.
    "add_turn": "AddBoundary",
    "answer_replay": "ResumeReplay",
    "await_awake": "SpinUntil",
    "call_terms": "CallOptions",
    "connection_terms": "ConnectionOptions",
    "core_use": "CpuThrottle",
    "crew": "WorkerPool",
    "crew_job": "ParallelJob",
    "draw_sharp": "DrawNearest",
    "draw_smooth": "DrawAntialiased",
    "episode_lack": "IncompleteReason",
    "game_art_facts": "GameArtSpec",
    "game_facts": "GameSpec",
    "hosted_pool": "PoolBackend",
    "joined_threads": "ThreadGroup",
    "lend_all": "ShareAll",
    "lent_rows": "CopyOnWriteRows",
    "look_at": "MakeCamera",
    "looks_before_sleep": "kSpinIterations",
    "near_end": "on_almost_done",
    "on_unseen": "OnInvalidated",
    "pool_host": "PoolBackendFactory",
    "pool_news": "PoolFeed",
    "pool_order": "CreatePoolOptions",
    "pool_surroundings": "PoolContext",
    "pool_tap": "PoolObserver",
    "pool_terms": "PoolOptions or PoolContext",
    "pool_view": "FramePublisher",
    "ring_by": "ArmBy",
    "shard_base": "ShardCheckpoint",
    "shard_terms": "ShardOptions or ShardContext",
    "sharp_picture": "nearest_sampling",
    "side_crew": "BackgroundExecutor",
    "sight_painter": "SceneSnapshotRenderer",
    "smooth_picture": "antialiased_sampling",
    "solo_pool": "SingleEnvPool",
    "step_run": "StepSegment",
    "still_layer": "StaticLayerCache",
    "stream_terms": "StreamOptions",
    "submit_and_help": "SubmitAndParticipate",
    "tell_taps": "NotifyObservers",
    "turned_picture": "rotated_image",
    "turned_rect": "RotatedRect",
    "turned_runs": "rotated_runs",
    "viewer_terms": "ViewerOptions",
    "watch_order": "WatchSpec",
    "workbench": "WorkerScratch",
    # Tests and tools.
    "action_tape": "ActionScript",
    "sprite_card": "SpriteSheet",
    "strangers_test": "UntrustedClientTest",
}

# The same for names that are ordinary words in another case or form, and for paths and phrases:
# these count as they are written, and whole.
EXACT = {
    "--art": "--art_dir",
    "--episode_bytes_max": "--episode_history_bytes_max",
    "AlarmTest": "DeadlineTimerTest",
    "Batch::LetGo": "Batch::Release",
    "CarryOut": "Execute",
    "Countdown": "CompletionLatch",
    "Dress": "StyleSprite",
    "FLAGS_art": "FLAGS_art_dir",
    "FLAGS_episode_bytes_max": "FLAGS_episode_history_bytes_max",
    "GoBack": "Rollback",
    "PictureCount": "FrameStackWarmup",
    "PlayOptions": "RolloutOptions",
    "ProcgenEnv1": "ProcgenGymEnv",
    "PutIn": "RestoredState",
    "PutStates": "ApplyStates",
    "ReadEpisode": "GetEpisode",
    "ReadEpisodeRequest": "GetEpisodeRequest",
    "Sight": "SceneSnapshot",
    "Standing": "Snapshot",
    "Steer": "MapControls",
    "TakeBackRows": "MaterializeRows",
    "Watcher": "FrameSubscriber",
    "class Alarm": "class DeadlineTimer",
    "class Sessions": "class PoolSupervisor",
    "envs.released": "envs.procgen_compat",
    "patience.h": "spin_wait.h",
    "readEpisode": "getEpisode",
    "read_episode": "get_episode",
    "stage.py": "testbed.py",
    "tests/fleet_faults": "tests/faults",
    "tests/hosts": "tests/faults",
    "the house": "the repository",
    "tools/pictures": "tools/art",
}

# The history of the names, and this table.
_EXCEPTED = ("CHANGELOG.md", "tests/tidy/retired.py")

# Without a plural: an episode ends, which tests say in their names.
_SINGULAR = ("episode_end",)

_TOKEN = re.compile(r"[A-Za-z]\w*(?:-[A-Za-z]\w*)*")
_PART = re.compile(r"[A-Z]+(?![a-z])|[A-Z]?[a-z]+|[0-9]+")
_WORDS = {tuple(name.split("_")): name for name in WORDS}
_LENGTHS = sorted({len(words) for words in _WORDS}, reverse=True)
_EXACT = {name: re.compile(rf"(?<![\w-]){re.escape(name)}(?![\w-])") for name in EXACT}


def _retired_part(token):
    """The retired name of WORDS that a name has within it, or None."""
    words = [word.lower() for word in _PART.findall(token)]
    for length in _LENGTHS:
        for begin in range(len(words) - length + 1):
            *part, last = words[begin:begin + length]
            singular = _WORDS.get((*part, last.removesuffix("s")))
            found = _WORDS.get((*part, last), singular if singular not in _SINGULAR else None)
            if found:
                return found
    return None


def _found_in(line, parts):
    """Pairs of what the line has and what to write. `parts`: names seen before, as a cache."""
    for token in dict.fromkeys(_TOKEN.findall(line)):
        if token not in parts:
            parts[token] = _retired_part(token)
        if parts[token]:
            yield token, WORDS[parts[token]]
    for name, pattern in _EXACT.items():
        if name in line and pattern.search(line):
            yield name, EXACT[name]


def check_retired_names(tree):
    """No retired name is in a text or a path."""
    parts = {}
    for path in tree.paths:
        if path in _EXCEPTED:
            continue
        for number, line in [(1, path), *tree.lines(path)]:
            for given, wanted in _found_in(line, parts):
                yield Violation(path, number, f"'{given}' is retired; write {wanted}")


RULES = (check_retired_names,)
