//! A random agent: random-agent ADDRESS STEPS
use pb::run_pool_request::Request as Kind;
use pb::run_pool_response::Response;
use pb::pool_service_client::PoolServiceClient as Service;
use std::time::Duration;
use tokio::sync::mpsc;
use tokio_stream::wrappers::UnboundedReceiverStream;
use tonic::transport::Channel;
use tonic::{Code, Status, Streaming};

#[allow(clippy::doc_lazy_continuation)]
mod pb {
    tonic::include_proto!("procgen.v1");
}

const ENV_COUNT: i32 = 4;
const ROUND_STEPS: i32 = 100; // Steps between two checkpoints.
const ACTION_COUNT: i32 = 15;

/// What a run needs to continue on a new stream.
#[derive(Default)]
struct Checkpoint {
    states: Vec<pb::State>,
    step: i32,
    returns: Vec<f32>, // Of the episodes that have ended.
}

/// A pool: it lives as long as its stream.
struct Pool {
    requests: mpsc::UnboundedSender<pb::RunPoolRequest>,
    responses: Streaming<pb::RunPoolResponse>,
}

impl Pool {
    /// Creates a pool that continues from snapshots.
    async fn start(channel: &Channel, states: Vec<pb::State>) -> Result<Pool, Status> {
        let (requests, receiver) = mpsc::unbounded_channel();
        let spec = pb::PoolSpec {
            games: vec!["coinrun".into()],
            env_count: ENV_COUNT,
            ..Default::default()
        };
        let start = pb::StartPool { spec: Some(spec), states, ..Default::default() };
        let _ = requests.send(pb::RunPoolRequest { request: Some(Kind::Start(start)) });
        let stream = UnboundedReceiverStream::new(receiver);
        let mut responses = Service::new(channel.clone()).run_pool(stream).await?.into_inner();
        responses.message().await?;
        Ok(Pool { requests, responses })
    }

    /// Sends a request and waits for its response.
    async fn call(&mut self, request: Kind) -> Result<Response, Status> {
        let _ = self.requests.send(pb::RunPoolRequest { request: Some(request) });
        let message = self.responses.message().await?.and_then(|message| message.response);
        message.ok_or_else(|| Status::unavailable("the stream has ended"))
    }
}

/// Steps a pool from a checkpoint, and updates it after each round.
async fn run(channel: &Channel, steps: i32, saved: &mut Checkpoint) -> Result<(), Status> {
    let mut pool = Pool::start(channel, saved.states.clone()).await?;
    while saved.step < steps {
        let mut returns = saved.returns.clone();
        for _ in 0..ROUND_STEPS {
            let actions = (0..ENV_COUNT).map(|_| rand::random_range(0..ACTION_COUNT)).collect();
            let slice = Some(pb::Slice { env_count: ENV_COUNT, ..Default::default() });
            let step = pb::Step { slice, actions, ..Default::default() };
            if let Response::Batch(batch) = pool.call(Kind::Step(step)).await? {
                // batch.observations: uint8 [4, 64, 64, 3]
                let ends = batch.terminated.iter().zip(&batch.truncated).map(|(a, b)| *a || *b);
                let ended = batch.episode_returns.iter().zip(ends).filter(|(_, end)| *end);
                returns.extend(ended.map(|(value, _)| value));
            }
        }
        if let Response::States(states) = pool.call(Kind::SaveStates(Default::default())).await? {
            *saved = Checkpoint { states: states.states, step: saved.step + ROUND_STEPS, returns };
        }
    }
    Ok(())
}

#[tokio::main(flavor = "current_thread")]
async fn main() -> Result<(), Box<dyn std::error::Error>> {
    let arguments: Vec<String> = std::env::args().collect();
    let steps = arguments[2].parse()?;
    let channel = Channel::from_shared(format!("http://{}", arguments[1]))?.connect_lazy();
    let mut saved = Checkpoint::default();
    let mut attempt = 0;
    while let Err(error) = run(&channel, steps, &mut saved).await {
        // Tonic reports a broken connection by any of these.
        let broken = [Code::Unavailable, Code::Unknown, Code::Internal, Code::Cancelled];
        if !broken.contains(&error.code()) || attempt == 30 {
            return Err(error.into());
        }
        attempt += 1;
        tokio::time::sleep(Duration::from_secs(1)).await;
        println!("continuing after {} steps: {}", saved.step, error.message());
    }
    let mean = saved.returns.iter().sum::<f32>() / saved.returns.len() as f32;
    println!("{} episodes, mean return {mean:.3}", saved.returns.len());
    Ok(())
}
