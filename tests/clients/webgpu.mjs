// A WebGPU client in Node (Dawn): finds the adapter, runs a compute shader, draws a triangle, checks both.
import {create, globals} from 'webgpu';

Object.assign(globalThis, globals);
const gpu = create(['backend=vulkan']);
const adapter = await gpu.requestAdapter();
if (!adapter) throw new Error('no adapter');
console.log('adapter:', adapter.info?.description, adapter.info?.vendor, adapter.info?.device);
const device = await adapter.requestDevice();
device.onuncapturederror = (event) => console.log('error:', event.error.message);

async function read(buffer, size) {
  const copy = device.createBuffer({size, usage: GPUBufferUsage.MAP_READ | GPUBufferUsage.COPY_DST});
  const encoder = device.createCommandEncoder();
  encoder.copyBufferToBuffer(buffer, 0, copy, 0, size);
  device.queue.submit([encoder.finish()]);
  await copy.mapAsync(GPUMapMode.READ);
  return copy.getMappedRange().slice(0);
}

async function compute() {
  const module = device.createShaderModule({code: `
    @group(0) @binding(0) var<storage, read_write> data: array<u32>;
    @compute @workgroup_size(64) fn main(@builtin(global_invocation_id) id: vec3u) { data[id.x] = id.x * id.x + 7u; }`});
  const pipeline = device.createComputePipeline({layout: 'auto', compute: {module, entryPoint: 'main'}});
  const buffer = device.createBuffer({size: 1024, usage: GPUBufferUsage.STORAGE | GPUBufferUsage.COPY_SRC});
  const group = device.createBindGroup({layout: pipeline.getBindGroupLayout(0), entries: [{binding: 0, resource: {buffer}}]});
  const encoder = device.createCommandEncoder();
  const pass = encoder.beginComputePass();
  pass.setPipeline(pipeline);
  pass.setBindGroup(0, group);
  pass.dispatchWorkgroups(4);
  pass.end();
  device.queue.submit([encoder.finish()]);
  const words = new Uint32Array(await read(buffer, 1024));
  return words.every((word, i) => word === i * i + 7);
}

async function triangle() {
  const module = device.createShaderModule({code: `
    @vertex fn vs(@builtin(vertex_index) i: u32) -> @builtin(position) vec4f {
      return vec4f(select(-1.0, 1.0, i == 1u), select(-1.0, 1.0, i == 2u), 0.0, 1.0);
    }
    @fragment fn fs() -> @location(0) vec4f { return vec4f(1.0, 0.4, 0.2, 1.0); }`});
  const pipeline = device.createRenderPipeline({
    layout: 'auto', vertex: {module, entryPoint: 'vs'},
    fragment: {module, entryPoint: 'fs', targets: [{format: 'rgba8unorm'}]},
  });
  const texture = device.createTexture({size: [64, 64], format: 'rgba8unorm',
                                        usage: GPUTextureUsage.RENDER_ATTACHMENT | GPUTextureUsage.COPY_SRC});
  const buffer = device.createBuffer({size: 64 * 256, usage: GPUBufferUsage.COPY_DST | GPUBufferUsage.COPY_SRC});
  const encoder = device.createCommandEncoder();
  const pass = encoder.beginRenderPass({colorAttachments: [
    {view: texture.createView(), clearValue: [0, 0, 1, 1], loadOp: 'clear', storeOp: 'store'}]});
  pass.setPipeline(pipeline);
  pass.draw(3);
  pass.end();
  encoder.copyTextureToBuffer({texture}, {buffer, bytesPerRow: 256}, [64, 64]);
  device.queue.submit([encoder.finish()]);
  const pixels = new Uint32Array(await read(buffer, 64 * 256));
  return pixels[56 * 64 + 8] === 0xFF3366FF && pixels[4 * 64 + 60] === 0xFFFF0000;
}

const results = {compute: await compute(), triangle: await triangle()};
console.log(results);
if (!results.compute || !results.triangle) process.exit(1);
console.log('all right');
process.exit(0);
