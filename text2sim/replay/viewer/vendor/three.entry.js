// What the viewer uses of three.js 0.187.0 (MIT). three.min.js is made of it by
//   npm install three@0.187.0 esbuild@0.28.2
//   npx esbuild three.entry.js --bundle --minify --format=iife --global-name=THREE --outfile=three.min.js
export {
  BufferAttribute, BufferGeometry, CanvasTexture, Color, DirectionalLight, DoubleSide, EquirectangularReflectionMapping, Fog,
  HemisphereLight, IcosahedronGeometry, InstancedMesh, Matrix4, MeshStandardMaterial, NeutralToneMapping, PerspectiveCamera, Points,
  PointsMaterial, Quaternion, Raycaster, Scene, SRGBColorSpace, TextureLoader, Vector2, Vector3, WebGLRenderer,
} from "three";
export { OrbitControls } from "three/addons/controls/OrbitControls.js";
