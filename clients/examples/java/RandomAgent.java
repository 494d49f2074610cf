import com.procgen.v1.Batch;
import com.procgen.v1.PoolServiceGrpc;
import com.procgen.v1.PoolSpec;
import com.procgen.v1.RunPoolRequest;
import com.procgen.v1.RunPoolResponse;
import com.procgen.v1.SaveEnvironments;
import com.procgen.v1.Slice;
import com.procgen.v1.StartPool;
import com.procgen.v1.State;
import com.procgen.v1.Step;
import io.grpc.Grpc;
import io.grpc.InsecureChannelCredentials;
import io.grpc.ManagedChannel;
import io.grpc.Status;
import io.grpc.StatusException;
import io.grpc.stub.BlockingClientCall;
import java.util.ArrayList;
import java.util.List;
import java.util.Random;

/** A random agent: RandomAgent ADDRESS STEPS */
public final class RandomAgent {
  private static final int ENV_COUNT = 4;
  private static final int ROUND_STEPS = 100; // Steps between two checkpoints.
  private static final int ACTION_COUNT = 15;

  // A checkpoint: what a run needs to continue on a new stream.
  private List<State> states = List.of();
  private int step = 0;
  private List<Float> returns = List.of(); // Of the episodes that have ended.

  private final Random random = new Random();

  private static BlockingClientCall<RunPoolRequest, RunPoolResponse> open(ManagedChannel channel) {
    return PoolServiceGrpc.newBlockingV2Stub(channel).runPool();
  }

  private static RunPoolResponse call(
      BlockingClientCall<RunPoolRequest, RunPoolResponse> stream, RunPoolRequest.Builder request)
      throws InterruptedException, StatusException {
    stream.write(request.build());
    return stream.read();
  }

  private RunPoolRequest.Builder randomStep() {
    Step.Builder step = Step.newBuilder().setSlice(Slice.newBuilder().setEnvCount(ENV_COUNT));
    for (int i = 0; i < ENV_COUNT; ++i) {
      step.addActions(random.nextInt(ACTION_COUNT));
    }
    return RunPoolRequest.newBuilder().setStep(step);
  }

  /** Steps a pool from the checkpoint, and updates it after each round. */
  private void run(ManagedChannel channel, int steps) throws InterruptedException, StatusException {
    var stream = open(channel); // The pool lives as long as it.
    var spec = PoolSpec.newBuilder().addGames("coinrun").setEnvCount(ENV_COUNT);
    var start = StartPool.newBuilder().setSpec(spec).addAllStates(states);
    call(stream, RunPoolRequest.newBuilder().setStart(start));
    while (step < steps) {
      List<Float> ended = new ArrayList<>(returns);
      for (int i = 0; i < ROUND_STEPS; ++i) {
        Batch batch = call(stream, randomStep()).getBatch(); // Observations: uint8 [4, 64, 64, 3]
        for (int env = 0; env < ENV_COUNT; ++env) {
          if (batch.getTerminated(env) || batch.getTruncated(env)) {
            ended.add(batch.getEpisodeReturns(env));
          }
        }
      }
      var save = RunPoolRequest.newBuilder().setSaveStates(SaveEnvironments.getDefaultInstance());
      states = call(stream, save).getStates().getStatesList();
      returns = ended;
      step += ROUND_STEPS;
    }
    stream.halfClose();
  }

  public static void main(String[] arguments) throws InterruptedException, StatusException {
    int steps = Integer.parseInt(arguments[1]);
    var channel = Grpc.newChannelBuilder(arguments[0], InsecureChannelCredentials.create()).build();
    var agent = new RandomAgent();
    for (int attempt = 0; agent.step < steps; ++attempt) {
      try {
        agent.run(channel, steps);
      } catch (StatusException error) {
        if (error.getStatus().getCode() != Status.Code.UNAVAILABLE || attempt == 30) {
          throw error;
        }
        Thread.sleep(1000);
        System.out.printf("continuing after %d steps: %s%n", agent.step, error.getMessage());
      }
    }
    channel.shutdownNow();
    double mean = agent.returns.stream().mapToDouble(Float::doubleValue).average().orElse(0);
    System.out.printf("%d episodes, mean return %.3f%n", agent.returns.size(), mean);
  }
}
