export const Muxer: any, ArrayBufferTarget: any;
