//! A random agent over the C ABI: random-agent ADDRESS STEPS. "" as ADDRESS: in this process.
use std::ffi::{c_char, c_int, c_void, CStr, CString};
use std::ptr::{null, null_mut};

const ENV_COUNT: usize = 4;
const OBSERVATION_BYTES: usize = 64 * 64 * 3;
const ACTION_COUNT: u64 = 15;

// The structs of procgen.h. They begin with their size, and a program may leave out their end.
#[repr(C)]
struct PoolOptions {
    struct_size: usize,
    games: *const *const c_char,
    game_count: i32,
    env_count: i32,
    first_env: i32,
    total_env_count: i32,
    distribution_mode: i32,
    num_levels: i32,
    start_level: i32,
    debug_mode: i32,
    rand_seed: i64,
    has_rand_seed: u8,
    flags: [u8; 7],
}

#[repr(C)]
struct Step {
    struct_size: usize,
    first_env: i32,
    env_count: i32,
    actions: *const i32,
}

#[repr(C)]
struct Batch {
    struct_size: usize,
    observations: *mut u8,
    rewards: *mut f32,
    first: *mut u8,
    terminated: *mut u8,
    truncated: *mut u8,
    level_seeds: *mut i32,
    prev_level_seeds: *mut i32,
    prev_level_complete: *mut u8,
    episode_returns: *mut f32,
}

#[link(name = "procgen_remote")]
extern "C" {
    fn procgen_error_message() -> *const c_char;
    fn procgen_pool_options_init(options: *mut PoolOptions, size: usize);
    fn procgen_connect(
        address: *const c_char,
        options: *const c_void,
        connection: *mut *mut c_void,
    ) -> c_int;
    fn procgen_connection_destroy(connection: *mut c_void);
    fn procgen_connection_create_pool(
        connection: *mut c_void,
        options: *const PoolOptions,
        server_options: *const c_void,
        pool: *mut *mut c_void,
    ) -> c_int;
    fn procgen_pool_create(options: *const PoolOptions, pool: *mut *mut c_void) -> c_int;
    fn procgen_pool_destroy(pool: *mut c_void);
    fn procgen_step(pool: *mut c_void, step: *const Step, batch: *const Batch) -> c_int;
}

/// Panics with the library's message if `code` is an error.
fn check(code: c_int) {
    let message = unsafe { CStr::from_ptr(procgen_error_message()) };
    assert!(code == 0, "{}", message.to_string_lossy());
}

fn main() {
    let arguments: Vec<String> = std::env::args().collect();
    let address = CString::new(arguments[1].as_str()).unwrap();
    let steps: i32 = arguments[2].parse().unwrap();

    let games = [c"coinrun".as_ptr()];
    let mut options: PoolOptions = unsafe { std::mem::zeroed() };
    let (mut connection, mut pool) = (null_mut(), null_mut());
    unsafe {
        procgen_pool_options_init(&mut options, size_of::<PoolOptions>());
        options.games = games.as_ptr();
        options.game_count = 1;
        options.env_count = ENV_COUNT as i32;
        options.rand_seed = 1;
        options.has_rand_seed = 1;
        if address.is_empty() {
            check(procgen_pool_create(&options, &mut pool));
        } else {
            check(procgen_connect(address.as_ptr(), null(), &mut connection));
            check(procgen_connection_create_pool(connection, &options, null(), &mut pool));
        }
    }

    let mut observations = vec![0u8; ENV_COUNT * OBSERVATION_BYTES]; // [4, 64, 64, 3]
    let (mut terminated, mut truncated) = ([0u8; ENV_COUNT], [0u8; ENV_COUNT]);
    let mut episode_returns = [0f32; ENV_COUNT];
    let mut batch: Batch = unsafe { std::mem::zeroed() }; // Null arrays are not written.
    batch.struct_size = size_of::<Batch>();
    batch.observations = observations.as_mut_ptr();
    batch.terminated = terminated.as_mut_ptr();
    batch.truncated = truncated.as_mut_ptr();
    batch.episode_returns = episode_returns.as_mut_ptr();

    let mut random = 1u64;
    let (mut count, mut sum) = (0, 0.0);
    for _ in 0..steps {
        let actions: [i32; ENV_COUNT] = std::array::from_fn(|_| {
            random = random.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            ((random >> 33) % ACTION_COUNT) as i32
        });
        let (size, env_count) = (size_of::<Step>(), ENV_COUNT as i32);
        let step = Step { struct_size: size, first_env: 0, env_count, actions: actions.as_ptr() };
        check(unsafe { procgen_step(pool, &step, &batch) });
        for env in 0..ENV_COUNT {
            if terminated[env] + truncated[env] > 0 {
                count += 1;
                sum += episode_returns[env];
            }
        }
    }
    println!("{count} episodes, mean return {:.3}", sum / count as f32);
    unsafe {
        procgen_pool_destroy(pool);
        procgen_connection_destroy(connection);
    }
}
