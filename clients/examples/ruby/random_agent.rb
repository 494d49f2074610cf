# A random agent: random_agent ADDRESS STEPS
require 'procgen/v1/pool_service_services_pb'

include Procgen::V1
SERVICE = PoolService::Stub

ENV_COUNT = 4
ROUND_STEPS = 100 # Steps between two checkpoints.
ACTION_COUNT = 15

# What a run needs to continue on a new stream. `returns`: of the episodes that have ended.
Checkpoint = Struct.new(:states, :step, :returns)

# A pool whose environments continue from snapshots. It lives as long as its stream.
class RunningPool
  def initialize(stub, states)
    @requests = Queue.new
    @responses = stub.run_pool(Enumerator.new { |to| loop { to << (@requests.pop || break) } })
    spec = PoolSpec.new(games: ['coinrun'], env_count: ENV_COUNT)
    call(start: StartPool.new(spec: spec, states: states))
  end

  # Sends a request and waits for its response.
  def call(request)
    @requests << RunPoolRequest.new(**request)
    @responses.next
  end

  def finish
    @requests << nil
    @responses.next
  rescue StopIteration
    nil
  end
end

# Steps a pool from a checkpoint, and updates it after each round.
def run(stub, steps, saved)
  pool = RunningPool.new(stub, saved.states)
  while saved.step < steps
    returns = saved.returns.dup
    ROUND_STEPS.times do
      actions = Array.new(ENV_COUNT) { rand(ACTION_COUNT) }
      batch = pool.call(step: Step.new(slice: Slice.new(env_count: ENV_COUNT), actions: actions)).batch
      # batch.observations: uint8 [4, 64, 64, 3]
      ENV_COUNT.times do |env|
        returns << batch.episode_returns[env] if batch.terminated[env] || batch.truncated[env]
      end
    end
    saved.states = pool.call(save_states: SaveEnvironments.new).states.states.to_a
    saved.returns = returns
    saved.step += ROUND_STEPS
  end
  pool.finish
end

$stdout.sync = true
steps = ARGV[1].to_i
saved = Checkpoint.new([], 0, [])
stub = SERVICE.new(ARGV[0], :this_channel_is_insecure)
attempt = 0
begin
  run(stub, steps, saved)
rescue GRPC::Unavailable => e
  raise if (attempt += 1) > 30

  sleep 1
  puts "continuing after #{saved.step} steps: #{e.details}"
  retry
end
mean = saved.returns.sum / saved.returns.size
puts format('%d episodes, mean return %.3f', saved.returns.size, mean)
