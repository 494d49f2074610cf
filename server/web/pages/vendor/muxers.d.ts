export const Mp4Muxer: any, Mp4Target: any, WebMMuxer: any, WebMTarget: any;
