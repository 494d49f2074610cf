export const create: any, createFileRegistry: any, fromBinary: any, toBinary: any, FileDescriptorSetSchema: any;
