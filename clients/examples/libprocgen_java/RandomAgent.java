import com.sun.jna.Library;
import com.sun.jna.Memory;
import com.sun.jna.Native;
import com.sun.jna.Pointer;
import com.sun.jna.Structure;
import com.sun.jna.Structure.FieldOrder;
import com.sun.jna.ptr.PointerByReference;
import java.util.Random;

/** A random agent over the C ABI: RandomAgent ADDRESS STEPS. "" as ADDRESS: in this process. */
public final class RandomAgent {
  private static final int ENV_COUNT = 4;
  private static final int OBSERVATION_BYTES = 64 * 64 * 3;
  private static final int ACTION_COUNT = 15;

  // The structs of procgen.h. They begin with their size, and a program may leave out their end.
  @FieldOrder({
    "structSize", "games", "gameCount", "envCount", "firstEnv", "totalEnvCount", "distributionMode",
    "numLevels", "startLevel", "debugMode", "randSeed", "hasRandSeed", "flags"
  })
  public static class PoolOptions extends Structure {
    public long structSize;
    public Pointer games;
    public int gameCount, envCount, firstEnv, totalEnvCount;
    public int distributionMode, numLevels, startLevel, debugMode;
    public long randSeed;
    public byte hasRandSeed;
    public byte[] flags = new byte[7];
  }

  @FieldOrder({"structSize", "firstEnv", "envCount", "actions"})
  public static class Step extends Structure {
    public long structSize;
    public int firstEnv, envCount;
    public Pointer actions;
  }

  @FieldOrder({
    "structSize", "observations", "rewards", "first", "terminated", "truncated", "levelSeeds",
    "prevLevelSeeds", "prevLevelComplete", "episodeReturns"
  })
  public static class Batch extends Structure {
    public long structSize;
    public Pointer observations, rewards, first, terminated, truncated; // Null: not written.
    public Pointer levelSeeds, prevLevelSeeds, prevLevelComplete, episodeReturns;
  }

  private interface Procgen extends Library {
    String procgen_error_message();
    void procgen_pool_options_init(PoolOptions options, long size);
    int procgen_connect(String address, Pointer options, PointerByReference connection);
    void procgen_connection_destroy(Pointer connection);
    int procgen_connection_create_pool(
        Pointer connection, PoolOptions options, Pointer serverOptions, PointerByReference pool);
    int procgen_pool_create(PoolOptions options, PointerByReference pool);
    void procgen_pool_destroy(Pointer pool);
    int procgen_step(Pointer pool, Step step, Batch batch);
  }

  private static final Procgen PROCGEN = Native.load("procgen_remote", Procgen.class);

  private static void check(int code) {
    if (code != 0) {
      throw new IllegalStateException(PROCGEN.procgen_error_message());
    }
  }

  public static void main(String[] arguments) {
    int steps = Integer.parseInt(arguments[1]);
    var options = new PoolOptions();
    PROCGEN.procgen_pool_options_init(options, options.size());
    var game = new Memory(8);
    game.setString(0, "coinrun");
    var games = new Memory(Native.POINTER_SIZE);
    games.setPointer(0, game);
    options.games = games;
    options.gameCount = 1;
    options.envCount = ENV_COUNT;
    options.randSeed = 1;
    options.hasRandSeed = 1;
    var connection = new PointerByReference();
    var pool = new PointerByReference();
    if (arguments[0].isEmpty()) {
      check(PROCGEN.procgen_pool_create(options, pool));
    } else {
      check(PROCGEN.procgen_connect(arguments[0], null, connection));
      check(PROCGEN.procgen_connection_create_pool(connection.getValue(), options, null, pool));
    }

    var step = new Step();
    step.structSize = step.size();
    step.envCount = ENV_COUNT;
    step.actions = new Memory(4 * ENV_COUNT);
    var batch = new Batch();
    batch.structSize = batch.size();
    batch.observations = new Memory(ENV_COUNT * OBSERVATION_BYTES); // [4, 64, 64, 3]
    batch.terminated = new Memory(ENV_COUNT);
    batch.truncated = new Memory(ENV_COUNT);
    batch.episodeReturns = new Memory(4 * ENV_COUNT);
    var random = new Random(1);
    int count = 0;
    double sum = 0;
    for (int i = 0; i < steps; ++i) {
      for (int env = 0; env < ENV_COUNT; ++env) {
        step.actions.setInt(4 * env, random.nextInt(ACTION_COUNT));
      }
      check(PROCGEN.procgen_step(pool.getValue(), step, batch));
      for (int env = 0; env < ENV_COUNT; ++env) {
        if (batch.terminated.getByte(env) + batch.truncated.getByte(env) > 0) {
          count += 1;
          sum += batch.episodeReturns.getFloat(4 * env);
        }
      }
    }
    PROCGEN.procgen_pool_destroy(pool.getValue());
    PROCGEN.procgen_connection_destroy(connection.getValue());
    System.out.printf("%d episodes, mean return %.3f%n", count, sum / count);
  }
}
