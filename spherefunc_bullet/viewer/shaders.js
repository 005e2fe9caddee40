// Programs for the graphics card. Colours leave them multiplied by their opacity, since pages show through.

const LIGHTING = `
  vec3 lit(vec3 colour, vec3 normal, vec3 toward, mat4 view) {
    if (dot(normal, toward) < 0.0) normal = -normal;
    vec3 light = normalize(mat3(view) * vec3(-0.45, -0.6, 0.95));
    float rim = 1.0 - dot(normal, toward);
    return colour * (0.5 + 0.55 * max(dot(normal, light), 0.0)) * (1.0 - 0.45 * rim * rim * rim);
  }`;

const SHADERS = {
  // Spheres as squares that face the eye, on which each pixel's ray meets the sphere exactly.
  spheres: [
    `uniform mat4 view, projection; uniform float radius;
    in vec2 corner; in vec3 center; in vec3 colour;
    out vec3 middle, place, tint;
    void main() {
      middle = (view * vec4(center, 1.0)).xyz;
      float distance = length(middle);
      vec3 away = middle / distance;
      vec3 right = normalize(cross(away, vec3(0.0, 1.0, 0.0)));
      float reach = radius * distance / sqrt(max(distance * distance - radius * radius, 1e-9));
      place = middle + (right * corner.x + cross(right, away) * corner.y) * reach * 1.05;
      tint = colour;
      gl_Position = projection * vec4(place, 1.0);
    }`,
    `uniform mat4 view, projection; uniform float radius, opacity;
    in vec3 middle, place, tint; out vec4 pixel;
    ${LIGHTING}
    void main() {
      vec3 ray = normalize(place);
      float nearest = dot(ray, middle);
      vec3 aside = middle - ray * nearest;
      float inside = radius * radius - dot(aside, aside);
      if (inside < 0.0) discard;
      vec3 hit = ray * (nearest - sqrt(inside));
      vec4 clip = projection * vec4(hit, 1.0);
      gl_FragDepth = clip.z / clip.w * 0.5 + 0.5;
      pixel = vec4(lit(tint, (hit - middle) / radius, -ray, view), 1.0) * opacity;
    }`,
  ],
  mesh: [
    `uniform mat4 view, projection;
    in vec3 position; out vec3 place;
    void main() { place = (view * vec4(position, 1.0)).xyz; gl_Position = projection * vec4(place, 1.0); }`,
    `uniform mat4 view; uniform vec3 tint; uniform float opacity;
    in vec3 place; out vec4 pixel;
    ${LIGHTING}
    void main() {
      vec3 normal = normalize(cross(dFdx(place), dFdy(place)));
      vec3 toward = -normalize(place);
      // Glass is densest where one looks along it, which shows its outline.
      float share = mix(opacity, min(1.0, opacity * 2.2), pow(1.0 - abs(dot(normal, toward)), 2.0));
      pixel = vec4(lit(tint, normal, toward, view), 1.0) * share;
    }`,
  ],
  // Cubes with edges as wide on the screen near and far.
  cubes: [
    `uniform mat4 view, projection; uniform float side;
    in vec3 corner; in vec2 across; in vec3 low; in vec4 colour;
    out vec2 at; out vec4 tint;
    void main() {
      at = across; tint = colour;
      gl_Position = projection * view * vec4(low + (corner * 0.95 + 0.025) * side, 1.0);
    }`,
    `uniform float edge;
    in vec2 at; in vec4 tint; out vec4 pixel;
    void main() {
      vec2 width = fwidth(at);
      vec2 border = min(at, 1.0 - at) / max(width, 1e-6);
      float line = 1.0 - smoothstep(0.8 * edge, 1.4 * edge, min(border.x, border.y));
      float share = tint.a < 0.0 ? line * -0.8 * tint.a : max(tint.a, line * (0.22 + 0.6 * tint.a));
      if (share < 0.004) discard;
      pixel = vec4(tint.rgb, 1.0) * share;
    }`,
  ],
  ground: [
    `uniform mat4 view, projection; uniform vec3 middle; uniform float reach;
    in vec2 corner; out vec2 place, aside;
    void main() {
      aside = corner; place = middle.xy + corner * reach;
      gl_Position = projection * view * vec4(place, 0.0, 1.0);
    }`,
    `uniform vec3 tint; uniform float square;
    in vec2 place, aside; out vec4 pixel;
    void main() {
      vec2 at = place / square;
      vec2 far = abs(fract(at - 0.5) - 0.5) / max(fwidth(at), 1e-6);
      float line = 1.0 - min(min(far.x, far.y) / 1.5, 1.0);
      float fade = 1.0 - smoothstep(0.55, 1.0, length(aside));
      pixel = vec4(tint, 1.0) * fade * (0.05 + 0.4 * line);
    }`,
  ],
};
