// The part of lz4js that is used here; it brings no types.
declare module "lz4js" {
  const lz4: { decompressFrame(frame: Uint8Array, content: Uint8Array): number };
  export default lz4;
}

declare module "lz4js/xxh32.js" {
  const xxh32: { hash(seed: number, bytes: Uint8Array, begin: number, length: number): number };
  export default xxh32;
}
