// An esbuild plugin that leaves out of three what this page does not use, two fifths of it: virtual reality, lights and
// shadows, environment maps, morphing, effects, and the shaders of all materials. The scenes use ShaderMaterial alone, with
// shaders of their own; any other material fails at once when it is drawn.
//
// Written for the pinned version of three: a file that has moved in another version fails the build.
import {existsSync, readFileSync} from 'node:fs';
import {dirname, join} from 'node:path';

// Files of three/src and what stands for them: what the renderer asks of a feature that is never used.
const replaced = {
  'extras/PMREMGenerator.js': 'export class PMREMGenerator {}',
  'renderers/shaders/DFGLUTData.js': 'export function getDFGLUT() { throw new Error("no physical materials in this build"); }',
  'renderers/shaders/ShaderChunk.js':
    'import colorspace_pars_fragment from "./ShaderChunk/colorspace_pars_fragment.glsl.js"; export const ShaderChunk = {colorspace_pars_fragment};',
  'renderers/shaders/ShaderLib.js': 'export const ShaderLib = {};',
  'renderers/webgl/WebGLEnvironments.js': 'export class WebGLEnvironments { get() { return null; } dispose() {} }',
  'renderers/webgl/WebGLLights.js': `export class WebGLLights {
    state = new Proxy({version: 0, numLightProbes: 0, numSpotLightShadowsWithMaps: 0}, {get: (state, name) => state[name] ?? []});
    setup() {} setupView() {} }`,
  'renderers/webgl/WebGLMaterials.js': 'export class WebGLMaterials { refreshFogUniforms() {} refreshMaterialUniforms() {} }',
  'renderers/webgl/WebGLMorphtargets.js': 'export class WebGLMorphtargets { update() {} }',
  'renderers/webgl/WebGLOutput.js': 'export class WebGLOutput {}',
  'renderers/webgl/WebGLShadowMap.js': 'export class WebGLShadowMap { enabled = false; render() {} }',
  'renderers/webgl/WebGLUniformsGroups.js': 'export class WebGLUniformsGroups { dispose() {} }',
  'renderers/webxr/WebXRManager.js': `export class WebXRManager {
    enabled = false; isPresenting = false;
    addEventListener() {} removeEventListener() {} setAnimationLoop() {} dispose() {} getEnvironmentBlendMode() {} }`,
};

// Methods of three that nothing calls. checkUnused() says if something does.
const unused = [
  'toJSON', 'fromJSON', 'raycast', 'computeTangents', 'computeVertexNormals', 'toNonIndexed',
  'setAxisAngleFromRotationMatrix', 'makeOrthographic', 'transformUv', 'setFromUnitVectors', 'distanceSqToSegment',
  'slerpFlat', 'attach', 'setViewOffset', 'clearViewOffset', 'intersectLine', 'intersectSphere', 'intersectPlane',
  'intersectsLine', 'setXYZW', 'multiplyQuaternionsFlat', 'makeRotationAxis', 'setFromMatrixScale',
  'setAxisAngleFromQuaternion', 'randomDirection', 'normalizeNormals', 'containsBox', 'transposeIntoArray',
  'setFromAttributeAndIndices', 'lerpHSL', 'rotateAround', 'setFromCenterAndSize', 'copyAt', 'setPosition',
  'setFromMatrix3', 'setFromArray', 'rotateTowards', 'setFocalLength', 'getFocalLength', 'getEffectiveFOV',
  'setFromPointsAndIndices', 'lerpColors', 'getWorldScale', 'rotateOnWorldAxis', 'makeBasis', 'makeShear',
  'setFromCylindrical', 'setFromSpherical', 'offsetHSL', 'getHexString', 'applyAxisAngle', 'projectOnPlane'].join('|');
// Functions of the renderer that nothing calls, `this.NAME = function`.
const unusedOfRenderer = [
  'compile', 'compileAsync', 'readRenderTargetPixels', 'readRenderTargetPixelsAsync', 'copyFramebufferToTexture', 'copyTextureToTexture',
  'initRenderTarget', 'initTexture', 'resetState', 'setRenderTargetTextures', 'setRenderTargetFramebuffer', 'setEffects', 'setNodesHandler',
  'forceContextRestore'].join('|');
const renderFunction = new RegExp(String.raw`^\t\tthis\.(?:${unusedOfRenderer}) = (?:async )?function .*\{\n(?:(?!\t\t\};$).*\n)*\t\t\};$`, 'gm');
// Functions within the renderer for features that the scenes do not use: render targets, cube textures, videos, transmission.
const never = ['uploadCubeTexture', 'setupFrameBufferTexture', 'setupRenderBufferStorage', 'setupDepthTexture', 'setupDepthRenderbuffer', 'rebindTextures',
  'setupRenderTarget', 'updateRenderTargetMipmap', 'updateMultisampleRenderTarget', 'updateVideoTexture', 'deallocateRenderTarget',
  'renderTransmissionPass'].join('|');
const featureFunction = new RegExp(String.raw`^(\t+)function (${never})\(.*\{\n(?:(?!\1\}$).*\n)*\1\}$`, 'gm');
const method = new RegExp(String.raw`^\t(?:static )?(?:${unused})\(.*\{\n(?:(?!\t\}$).*\n)*\t\}$`, 'gm');
const withoutUnused = (source) => source.replace(method, '').replace(renderFunction, '')
  .replace(featureFunction, (_, indent, name) => `${indent}function ${name}() { throw new Error('three.mjs: ${name}'); }`);

// Fails if built code calls a method that was left out.
export function checkUnused(code) {
  const call = new RegExp(String.raw`\.(${unused}|${unusedOfRenderer})\(`).exec(code);
  if (call) throw new Error(`three.mjs: something calls ${call[1]}; take it off the list of unused methods`);
}

export function leanThree(here) {
  const source = join(here, 'node_modules/three/src');
  for (const path of Object.keys(replaced))
    if (!existsSync(join(source, path))) throw new Error(`three.mjs: three has no ${path} any more`);
  return {
    name: 'lean-three',
    setup(build) {
      build.onResolve({filter: /^three$/}, () => ({path: join(source, 'Three.js'), sideEffects: false}));
      build.onLoad({filter: /[\\/]three[\\/]src[\\/].*\.js$/}, ({path}) => {
        const contents = replaced[path.slice(source.length + 1).replaceAll('\\', '/')];
        return {contents: contents ?? withoutUnused(readFileSync(path, 'utf8')), resolveDir: dirname(path)};
      });
    },
  };
}
