// In the browser: models as three.js loads them, white and under ambient light alone, so that what can be seen is occlusion.

import * as THREE from 'three';
import { GLTFLoader } from 'three/addons/loaders/GLTFLoader.js';

const SIDE_PX = 640;
/** From where models are looked at, from their middle. */
const VIEWS = [new THREE.Vector3(0.55, 0.35, 1), new THREE.Vector3(-0.7, -0.25, -1)];

/** Loads a model; resolves when its textures are there too. */
async function load(url) {
    const gltf = await new GLTFLoader().loadAsync(url);
    const meshes = [];
    gltf.scene.traverse((object) => object.isMesh && meshes.push(object));
    // The loader copies a material for surfaces that need it otherwise; a file's material is told by its index.
    const materials = new Map();
    for (const { material, geometry } of meshes) {
        const index = gltf.parser.associations.get(material)?.materials ?? material.uuid;
        if (!material.aoMap) {
            materials.set(index, materials.get(index) ?? { name: material.name });
            continue;
        }
        const { channel, image } = material.aoMap;
        const uvs = channel === 0 ? 'uv' : `uv${channel}`;
        const lacking = materials.get(index)?.lacking || !geometry.hasAttribute(uvs);
        materials.set(index, { name: material.name, channel, size: [image?.width ?? 0, image?.height ?? 0], lacking });
    }
    meshes.forEach((mesh) => (mesh.material = white(mesh.material)));
    return { scene: gltf.scene, meshes, materials: [...materials.values()] };
}

/** A white surface that shows a material's occlusion, and its alpha, and nothing else. */
function white({ aoMap, aoMapIntensity, side, map, alphaTest, transparent, opacity }) {
    const cut = alphaTest > 0 || transparent;
    const bare = { aoMap, aoMapIntensity, side, alphaTest, transparent, opacity, map: cut ? map : null };
    const material = new THREE.MeshLambertMaterial(bare);
    material.onBeforeCompile = (shader) => {
        const alphaAlone = '#ifdef USE_MAP\n diffuseColor.a *= texture2D( map, vMapUv ).a;\n#endif';
        shader.fragmentShader = shader.fragmentShader.replace('#include <map_fragment>', alphaAlone);
    };
    return material;
}

/** A model from one side, in linear values: what is open shows as 1. A canvas with nothing where the model is not. */
function draw(renderer, { scene }, towards) {
    const sphere = new THREE.Box3().setFromObject(scene).getBoundingSphere(new THREE.Sphere());
    const camera = new THREE.PerspectiveCamera(35, 1, sphere.radius * 0.1, sphere.radius * 10);
    camera.position.copy(towards).setLength(sphere.radius / Math.sin(THREE.MathUtils.degToRad(35 / 2))).add(sphere.center);
    camera.lookAt(sphere.center);
    const world = new THREE.Scene();
    // A white surface sends back 1 / pi of the light on it.
    world.add(scene, new THREE.AmbientLight(0xffffff, Math.PI));
    renderer.render(world, camera);
    const canvas = document.createElement('canvas');
    canvas.width = canvas.height = SIDE_PX;
    canvas.getContext('2d', { willReadFrequently: true }).drawImage(renderer.domElement, 0, 0);
    return canvas;
}

/** Green values, 0 to 1, of the pixels that the model covers. */
function values(canvas) {
    const { data } = canvas.getContext('2d').getImageData(0, 0, SIDE_PX, SIDE_PX);
    const found = [];
    for (let k = 0; k < data.length; k += 4) if (data[k + 3] === 255) found.push(data[k + 1] / 255);
    return found;
}

/** Puts models side by side, each as all views see it; tells what was loaded, and what of it is seen. */
async function show(urls) {
    const renderer = new THREE.WebGLRenderer({ antialias: true, alpha: true, preserveDrawingBuffer: true });
    renderer.setSize(SIDE_PX, SIDE_PX);
    renderer.outputColorSpace = THREE.LinearSRGBColorSpace;
    const picture = document.getElementById('picture');
    [picture.width, picture.height] = [SIDE_PX * urls.length, SIDE_PX * VIEWS.length];
    const into = picture.getContext('2d');
    into.fillStyle = '#204060';
    into.fillRect(0, 0, picture.width, picture.height);
    const report = [];
    for (const [column, url] of urls.entries()) {
        const model = await load(url);
        const occluded = VIEWS.map((view) => draw(renderer, model, view));
        occluded.forEach((canvas, row) => into.drawImage(canvas, column * SIDE_PX, row * SIDE_PX));
        model.meshes.forEach(({ material }) => (material.aoMapIntensity = 0));
        const open = VIEWS.map((view) => draw(renderer, model, view));
        report.push({ materials: model.materials, ...compare(occluded.flatMap(values), open.flatMap(values)) });
    }
    return report;
}

/** What the pixels say: how many, their mean and standard deviation, and how much darker occlusion made them. */
function compare(occluded, open) {
    const mean = (all) => all.reduce((sum, value) => sum + value, 0) / Math.max(all.length, 1);
    const average = mean(occluded);
    const sd = Math.sqrt(mean(occluded.map((value) => (value - average) ** 2)));
    return { pixels: occluded.length, mean: average, sd, darkening: mean(open) - average };
}

window.show = show;
