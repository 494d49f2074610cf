//! Generates the stubs from the folder PROCGEN_PROTO.
fn main() -> std::io::Result<()> {
    let folder = std::env::var("PROCGEN_PROTO").expect("PROCGEN_PROTO is set");
    tonic_prost_build::configure()
        .build_server(false)
        .compile_protos(&["procgen/v1/pool_service.proto"], &[&folder])
}
