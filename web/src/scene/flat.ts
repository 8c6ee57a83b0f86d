// A material of one colour, or with a picture, without light.
import {type Color, DoubleSide, GLSL3, ShaderMaterial, type Texture} from 'three';

// `upright`: faces the camera and stands upright.
const vertexShader = (upright: boolean): string => `
out vec2 at;
void main() {
  at = uv;
  gl_Position = projectionMatrix * (${upright ? 'modelViewMatrix[3] + vec4(position.xy, 0.0, 0.0)' : 'modelViewMatrix * vec4(position, 1.0)'});
}`;
const fragmentShader = (map: boolean): string => `
in vec2 at;
out vec4 shown;
uniform vec3 colour;
uniform float opacity;
${map ? 'uniform sampler2D map;' : ''}
void main() {
  shown = vec4(${map ? 'texture(map, at).rgb' : 'colour'}, opacity);
}`;

// `through`: drawn over what is in front of it. Its colour is uniforms.colour.
export function flat(colour: Color, options: {opacity?: number; map?: Texture; through?: boolean; upright?: boolean} = {}): ShaderMaterial {
  const {opacity = 1, map = null, through = false, upright = false} = options;
  return new ShaderMaterial({
    glslVersion: GLSL3, vertexShader: vertexShader(upright), fragmentShader: fragmentShader(map !== null), side: DoubleSide,
    transparent: opacity < 1 || through, depthWrite: opacity === 1, depthTest: !through, uniforms: {colour: {value: colour}, opacity: {value: opacity}, map: {value: map}}});
}
