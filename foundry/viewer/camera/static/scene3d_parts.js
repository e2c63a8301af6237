// The objects that the 3D view adds to a scene: the agent, its field of view, its path, its target. Metres, Z up.
"use strict";

window.FoundrySceneParts = (() => {
  const THREE = window.THREE;
  const RED = 0xdb141f, DARK_RED = 0x9e0a14, SKIN = 0xedc29e, HAIR = 0x33261f;
  const TRAIL = 0xf27300, EYE = 0x1668c7, TARGET = 0x0a9d58, BLOCKED = 0xd81b7a;
  const FULL_HEIGHT = 1.75, DASHES = 20;

  const radians = (degrees) => THREE.MathUtils.degToRad(degrees);
  const plain = (color, opacity = 1) =>
    new THREE.MeshBasicMaterial({ color, opacity, transparent: opacity < 1, depthWrite: opacity === 1 });

  /** A red figure of a person at the origin, Z up, looking along +X. */
  function makeAvatar(height) {
    const person = new THREE.Group();
    const add = (geometry, color, x, y, z) => {
      const part = new THREE.Mesh(geometry, new THREE.MeshLambertMaterial({ color, transparent: true }));
      part.position.set(x, y, z);
      part.renderOrder = 2;
      person.add(part);
      return part;
    };
    const upright = (radius, length) => new THREE.CapsuleGeometry(radius, length, 6, 16).rotateX(Math.PI / 2);
    add(new THREE.SphereGeometry(0.13, 24, 16), SKIN, 0, 0, 1.6);
    add(new THREE.SphereGeometry(0.135, 24, 16), HAIR, -0.03, 0, 1.63);
    add(new THREE.ConeGeometry(0.03, 0.1, 12).rotateZ(-Math.PI / 2), SKIN, 0.15, 0, 1.59);
    add(upright(0.18, 0.38), RED, 0, 0, 1.14);
    for (const side of [-1, 1]) {
      add(upright(0.06, 0.46), RED, 0.02, side * 0.27, 1.08);
      add(upright(0.08, 0.68), DARK_RED, 0, side * 0.1, 0.48);
      add(new THREE.SphereGeometry(0.09, 16, 12).scale(1.3, 0.8, 0.7), HAIR, 0.06, side * 0.1, 0.06);
    }
    person.scale.setScalar(height / FULL_HEIGHT);
    return person;
  }

  /** The field of view: a pyramid along +X with its tip at the origin and the actual angles. */
  function makeCone(lens, length) {
    const high = length * Math.tan(radians(lens.fov) / 2), wide = high * lens.aspect;
    const corners = [[wide, high], [-wide, high], [-wide, -high], [wide, -high]].map(([y, z]) => [length, y, z]);
    const sides = corners.flatMap((corner, i) => [[0, 0, 0], corner, corners[(i + 1) % 4]]);
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute("position", new THREE.Float32BufferAttribute(sides.flat(), 3));
    const faces = new THREE.Mesh(geometry, plain(EYE, 0.14));
    faces.material.side = THREE.DoubleSide;
    const edges = new THREE.LineSegments(new THREE.EdgesGeometry(geometry), new THREE.LineBasicMaterial({ color: EYE }));
    return new THREE.Group().add(faces, edges);
  }

  /** A line of rods with a ball at every stop. `show(k)` shows its first k rods and k + 1 balls. */
  function makeTrail(points, radius, opacity, color = TRAIL) {
    const group = new THREE.Group(), material = plain(color, opacity);
    // A path behind a wall stays visible; "transparent" draws it after transparent surfaces.
    Object.assign(material, { depthTest: false, transparent: true });
    const balls = new THREE.InstancedMesh(new THREE.SphereGeometry(radius * 1.8, 12, 8), material, points.length);
    const rods = new THREE.InstancedMesh(new THREE.CylinderGeometry(radius, radius, 1, 8), material, points.length);
    const place = new THREE.Object3D(), up = new THREE.Vector3(0, 1, 0), along = new THREE.Vector3();
    points.forEach((point, i) => {
      place.position.copy(point);
      place.quaternion.identity();
      place.scale.setScalar(1);
      place.updateMatrix();
      balls.setMatrixAt(i, place.matrix);
      if (i === 0) return;
      along.subVectors(point, points[i - 1]);
      const length = along.length();
      place.position.addVectors(point, points[i - 1]).multiplyScalar(0.5);
      place.scale.set(1, length, 1);
      if (length > 0) place.quaternion.setFromUnitVectors(up, along.divideScalar(length));
      place.updateMatrix();
      rods.setMatrixAt(i - 1, place.matrix);
    });
    balls.frustumCulled = rods.frustumCulled = false;
    balls.renderOrder = rods.renderOrder = 1;
    group.add(balls, rods);
    group.show = (count) => {
      balls.count = Math.min(count + 1, points.length);
      rods.count = Math.min(count, Math.max(points.length - 1, 0));
    };
    group.show(points.length);
    return group;
  }

  /** Boxes around the prims of the target, [[x, y, z], [x, y, z]] each, and a pin above them. */
  function makeTarget(boxes) {
    const group = new THREE.Group(), all = new THREE.Box3();
    for (const [low, high] of boxes) {
      const box = new THREE.Box3(new THREE.Vector3(...low), new THREE.Vector3(...high)).expandByScalar(0.02);
      group.add(new THREE.Box3Helper(box, TARGET));
      all.union(box);
    }
    const pin = new THREE.Mesh(new THREE.ConeGeometry(0.09, 0.28, 16).rotateX(-Math.PI / 2), plain(TARGET));
    group.userData.middle = all.getCenter(new THREE.Vector3());
    pin.position.copy(group.userData.middle);
    pin.position.z = all.max.z + 0.25;
    for (const part of group.add(pin).children) {
      part.renderOrder = 2;
      part.material.depthTest = false;
    }
    return group;
  }

  /** A straight line from the eye to the target, visible through all objects. It is broken if an object is in between. */
  function makeSight(eye, target, clear, radius) {
    const line = new THREE.Group(), way = target.clone().sub(eye), length = way.length(), count = clear ? 1 : DASHES;
    const piece = new THREE.CylinderGeometry(radius, radius, length / count * (clear ? 1 : 0.5), 8);
    const material = Object.assign(plain(clear ? TARGET : BLOCKED), { depthTest: false, transparent: true });
    for (let i = 0; i < count; i += 1) {
      const rod = new THREE.Mesh(piece, material);
      rod.position.y = (i + 0.5) * length / count;
      rod.renderOrder = 2;
      line.add(rod);
    }
    line.position.copy(eye);
    line.quaternion.setFromUnitVectors(new THREE.Vector3(0, 1, 0), way.normalize());
    return line;
  }

  /** Frees the memory of an object on the graphics card, and removes the object from its parent. */
  function discard(thing) {
    thing.removeFromParent();
    thing.traverse((part) => {
      part.geometry?.dispose();
      part.material?.map?.dispose();
      part.material?.dispose();
    });
  }

  return { FULL_HEIGHT, TARGET, radians, makeAvatar, makeCone, makeTrail, makeTarget, makeSight, discard };
})();
