#include "render/body_tables.h"

#include <algorithm>
#include <cstdint>
#include <iterator>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

#include "fixtures/bodies/body.h"
#include "fixtures/bodies/closed.h"
#include "fixtures/bodies/levels.h"
#include "render/texture_tables.h"

namespace footlight::render {
namespace {

// The body of a type that brings no models, its vertices' parts as FL_PART_...: every part of the mesh is brought into
// the space behind the last joint that moves it.
fixtures::BodyMesh plain_body(const fixtures::Rig& rig, const fixtures::TypeSource& source) {
  using namespace fixtures;
  const FixtureType& type = rig.types[static_cast<std::size_t>(source.type)];
  const Mode& mode = type.modes[static_cast<std::size_t>(source.mode)];
  if (source.head != 0 || mode.geometries.size() != 4) return {};
  BodyMesh mesh = make_body(type.body, body_size(type, mode));
  constexpr std::array<int, 4> kGeometryOfPart = {kSimpleBase, kSimpleYoke, kSimpleHead, kSimpleHead};
  for (BodyVertex& vertex : mesh.vertices) {
    int geometry = kGeometryOfPart[vertex.part];
    glm::dmat4 pose(1);  // from the part to the space behind the joint
    std::uint32_t depth = 0;
    for (; geometry != kNoIndex; geometry = mode.geometries[static_cast<std::size_t>(geometry)].parent) {
      const auto joint = std::find(source.joint_geometries.rbegin(), source.joint_geometries.rend(), geometry);
      if (joint != source.joint_geometries.rend()) {
        depth = static_cast<std::uint32_t>(source.joint_geometries.rend() - joint);
        break;
      }
      pose = mode.geometries[static_cast<std::size_t>(geometry)].pose * pose;
    }
    const glm::dvec3 position = pose * glm::dvec4(vertex.position[0], vertex.position[1], vertex.position[2], 1);
    const glm::dvec3 normal = glm::dmat3(pose) * glm::dvec3(vertex.normal[0], vertex.normal[1], vertex.normal[2]);
    for (int i = 0; i < 3; ++i) {
      vertex.position[i] = static_cast<float>(position[i]);
      vertex.normal[i] = static_cast<float>(normal[i]);
    }
    vertex.part = depth | (vertex.part == kPartLens ? FL_PART_LENS : 0);
  }
  return mesh;
}

// One mesh for each row of compiled.types; empty: no body.
std::vector<fixtures::BodyMesh> bodies_of(const fixtures::Rig& rig, const fixtures::CompiledRig& compiled,
                                          fixtures::Diagnostics& diagnostics) {
  using namespace fixtures;
  static_assert(kBodyDepth == FL_PART_DEPTH && kBodyLens == FL_PART_LENS);
  std::size_t models = 0;
  for (const TypeSource& source : compiled.sources) {
    if (source.head != 0) continue;
    const FixtureType& type = rig.types[static_cast<std::size_t>(source.type)];
    models += model_count(type.modes[static_cast<std::size_t>(source.mode)]);
  }
  std::vector<BodyMesh> bodies;
  BodyBudget budget;
  while (bodies.size() < compiled.sources.size()) {
    // The heads of one mode are neighbours.
    const TypeSource& first = compiled.sources[bodies.size()];
    std::vector<BodyHead> heads;
    for (std::size_t t = bodies.size(); t < compiled.sources.size(); ++t) {
      const TypeSource& source = compiled.sources[t];
      if (source.type != first.type || source.mode != first.mode || (t > bodies.size() && source.head == 0)) break;
      heads.push_back({source.geometry, source.joint_geometries});
    }
    const FixtureType& type = rig.types[static_cast<std::size_t>(first.type)];
    const Mode& mode = type.modes[static_cast<std::size_t>(first.mode)];
    if (model_count(mode) > 0) {
      auto made = fixture_bodies(type, mode, heads, model_triangles(models), diagnostics, &budget);
      std::move(made.begin(), made.end(), std::back_inserter(bodies));
    } else {
      for (std::size_t i = 0; i < heads.size(); ++i) bodies.push_back(plain_body(rig, compiled.sources[bodies.size()]));
    }
  }
  return bodies;
}

// Replaces the numbers of sheens in the vertices of a body by those of the table.
void number_sheens(fixtures::BodyMesh& body, std::size_t heads, SheenTable& sheens) {
  static_assert(fixtures::kBodySheenShift == FL_PART_SHEEN_SHIFT);
  std::vector<std::uint32_t> numbers{0};
  for (const fixtures::BodySheen& each : body.sheens) {
    numbers.push_back(heads <= FL_HEADS_SHEEN_MAX ? sheens.number(each.sheen, each.color) : 0);
  }
  for (fixtures::BodyVertex& vertex : body.vertices) {
    const std::uint32_t sheen = numbers[vertex.part >> FL_PART_SHEEN_SHIFT];
    vertex.part = (vertex.part & (FL_PART_DEPTH | FL_PART_LENS)) | sheen << FL_PART_SHEEN_SHIFT;
  }
}

// The objects of the scene in stage space; their albedo, or the number of their texture, is in the parts of their
// vertices.
fixtures::BodyMesh objects_of(const fixtures::Rig& rig, fixtures::Diagnostics& diagnostics,
                              std::vector<fixtures::SolidBox>* object_solids, ObjectTextures& textures,
                              SheenTable& sheens) {
  const fixtures::Mesh scene = fixtures::scene_mesh(rig, diagnostics, object_solids);
  textures = object_textures(scene, sheens);
  fixtures::BodyMesh mesh;
  mesh.indices = scene.indices;
  for (const fixtures::MeshVertex& vertex : scene.vertices) {
    const glm::vec3 albedo = glm::clamp(scene.materials[vertex.material].albedo, 0.0f, 1.0f) * 1023.0f + 0.5f;
    const std::uint32_t plain = FL_OBJECT | static_cast<std::uint32_t>(albedo.x) << 20 |
                                static_cast<std::uint32_t>(albedo.y) << 10 | static_cast<std::uint32_t>(albedo.z);
    const std::uint32_t texture = textures.material[vertex.material];
    const std::uint32_t part = texture == FL_NONE ? plain : FL_OBJECT | FL_OBJECT_TEXTURED | texture;
    const glm::vec3& p = vertex.position_m;
    const glm::vec3& n = vertex.normal;
    mesh.vertices.push_back({{p.x, p.y, p.z}, {n.x, n.y, n.z}, part});
  }
  return mesh;
}

// The vertices behind a number of joints.
std::vector<glm::vec3> points_behind(const fixtures::BodyMesh& mesh, std::uint32_t depth) {
  std::vector<glm::vec3> points;
  for (const fixtures::BodyVertex& vertex : mesh.vertices) {
    if ((vertex.part & FL_PART_DEPTH) != depth) continue;
    points.emplace_back(vertex.position[0], vertex.position[1], vertex.position[2]);
  }
  return points;
}

// The corners of the box around points, at least one.
std::pair<glm::vec3, glm::vec3> corners_of(const std::vector<glm::vec3>& points) {
  glm::vec3 low = points.front();
  glm::vec3 high = low;
  for (const glm::vec3& p : points) {
    low = glm::min(low, p);
    high = glm::max(high, p);
  }
  return {low, high};
}

// Behind how many joints of its head a mirror ball is, if it turns alone there.
std::optional<std::uint32_t> ball_of(const fixtures::Rig& rig, const fixtures::TypeSource& source) {
  if (source.geometry == fixtures::kNoIndex || source.joint_geometries.empty()) return {};
  const fixtures::FixtureType& type = rig.types[static_cast<std::size_t>(source.type)];
  const fixtures::Mode& mode = type.modes[static_cast<std::size_t>(source.mode)];
  const bool ball = mode.geometries[static_cast<std::size_t>(source.geometry)].mirror_ball != fixtures::kNoIndex;
  if (!ball || source.joint_geometries.back() != source.geometry) return {};
  return static_cast<std::uint32_t>(source.joint_geometries.size());
}

// Spheres round the vertices behind each number of joints.
void add_spheres(const fixtures::BodyMesh& mesh, BodyMeshRow& row) {
  for (std::uint32_t depth = 0; depth < std::size(row.sphere); ++depth) {
    const std::vector<glm::vec3> points = points_behind(mesh, depth);
    row.sphere[depth] = vec4(0, 0, 0, -1);
    if (points.empty()) continue;
    const auto [low, high] = corners_of(points);
    const glm::vec3 centre = 0.5f * (low + high);
    float radius = 0;
    for (const glm::vec3& p : points) radius = std::max(radius, glm::length(p - centre));
    row.sphere[depth] = vec4(centre, radius);
  }
}

// A cube in place of a ball, half as wide as this share of the ball's radius, hides as much light: on average over its
// directions it shows 1.5 of its faces, pi r^2.
constexpr float kBallCube = 0.7236F;

// Boxes around the same vertices. `ball`: behind how many joints there is a ball.
void add_boxes(const fixtures::BodyMesh& mesh, const std::optional<std::uint32_t>& ball,
               std::vector<BodyBoxRow>& boxes) {
  for (std::uint32_t depth = 0; depth < FL_BODY_BOXES; ++depth) {
    const std::vector<glm::vec3> points = points_behind(mesh, depth);
    if (points.empty()) {
      boxes.push_back({vec4(0, 0, 0, -1), vec4(0)});
      continue;
    }
    const auto [low, high] = corners_of(points);
    // Plates get a millimetre: which way a plate faces the light has to be certain.
    const float share = ball == depth ? kBallCube : 1.0F;
    const glm::vec3 half = glm::max(0.5f * share * (high - low), glm::vec3(5e-4f));
    boxes.push_back({vec4(0.5f * (low + high), 0), vec4(half, 0)});
  }
}

// The shells of objects, a row for each workgroup that has triangles of closed ones.
std::vector<ObjectShellsRow> object_shells(const fixtures::BodyMesh& mesh, const fixtures::ShellOrder& order) {
  struct Box {
    glm::vec3 low{std::numeric_limits<float>::max()};
    glm::vec3 high{std::numeric_limits<float>::lowest()};
  };
  std::vector<Box> boxes(order.number.size());
  for (std::size_t i = 0; i < mesh.indices.size(); ++i) {
    const float* p = mesh.vertices[mesh.indices[i]].position;
    Box& box = boxes[order.number[i / 3]];
    box.low = glm::min(box.low, glm::vec3(p[0], p[1], p[2]));
    box.high = glm::max(box.high, glm::vec3(p[0], p[1], p[2]));
  }
  std::vector<ObjectShellsRow> rows;
  for (std::size_t first = 0; first < order.closed; first += FL_OBJECT_TRIANGLES) {
    Box all;
    for (std::size_t t = first; t < std::min<std::size_t>(first + FL_OBJECT_TRIANGLES, order.closed); ++t) {
      all.low = glm::min(all.low, boxes[order.number[t]].low);
      all.high = glm::max(all.high, boxes[order.number[t]].high);
    }
    rows.push_back({vec4(all.low, 0), vec4(all.high, 0)});
  }
  return rows;
}

// Ten bits, each followed by two zeros.
std::uint32_t spread_bits(std::uint32_t bits) {
  bits = (bits | bits << 16) & 0x030000ff;
  bits = (bits | bits << 8) & 0x0300f00f;
  bits = (bits | bits << 4) & 0x030c30c3;
  return (bits | bits << 2) & 0x09249249;
}

// Numbers what hides light in place of the bodies along a Z-order curve through the places where they hang.
void number_occluders(const fixtures::CompiledRig& compiled, std::vector<BodySlotRow>& slots) {
  const auto place_of = [&](const BodySlotRow& slot) {
    const fixtures::HeadRow& head = compiled.heads[slot.head];
    return glm::vec3(head.pose_0.w, head.pose_1.w, head.pose_2.w);
  };
  glm::vec3 low(std::numeric_limits<float>::max());
  glm::vec3 high(std::numeric_limits<float>::lowest());
  for (const BodySlotRow& slot : slots) {
    low = glm::min(low, place_of(slot));
    high = glm::max(high, place_of(slot));
  }
  const float largest_m = std::max({high.x - low.x, high.y - low.y, high.z - low.z, 1e-3F});
  std::vector<std::pair<std::uint32_t, std::size_t>> order;
  for (std::size_t i = 0; i < slots.size(); ++i) {
    const glm::vec3 at = 1023.0F / largest_m * (place_of(slots[i]) - low);
    const auto bits = [](float x) { return spread_bits(static_cast<std::uint32_t>(std::clamp(x, 0.0F, 1023.0F))); };
    order.emplace_back(bits(at.x) | bits(at.y) << 1 | bits(at.z) << 2, i);
  }
  std::sort(order.begin(), order.end());
  for (std::size_t i = 0; i < order.size(); ++i) slots[order[i].second].occluder = static_cast<std::uint32_t>(i);
}

}  // namespace

Status make_bodies(vk::Device& device, const fixtures::Rig& rig, const fixtures::CompiledRig& compiled,
                   fixtures::Diagnostics& diagnostics, RigTables& r, std::vector<fixtures::SolidBox>* object_solids,
                   SheenTable& sheens) {
  static_assert(fixtures::kBodyLevelsMax == FL_BODY_LEVELS);
  static_assert(sizeof(fixtures::BodyVertex) == sizeof(BodyVertexRow));
  std::vector<fixtures::BodyVertex> vertices;
  std::vector<std::uint32_t> indices;
  std::vector<BodySlotRow> slots;
  std::vector<BodyMeshRow> meshes;
  std::vector<BodyLevelRow> levels;
  std::vector<BodyBoxRow> boxes;
  std::vector<VkDrawIndexedIndirectCommand> draws;
  std::uint64_t rounds = 0;  // workgroups that draw bodies, at most
  const auto add = [&](const fixtures::BodyMesh& mesh, const fixtures::ShellOrder& order, std::uint32_t count,
                       double error_m) {
    levels.push_back({static_cast<std::uint32_t>(indices.size()), static_cast<std::uint32_t>(mesh.indices.size()),
                      static_cast<std::uint32_t>(vertices.size()), static_cast<float>(error_m),
                      static_cast<std::uint32_t>(r.body_triangles), order.outward, order.closed});
    draws.push_back({static_cast<std::uint32_t>(mesh.indices.size()), count, static_cast<std::uint32_t>(indices.size()),
                     static_cast<std::int32_t>(vertices.size()), 0});
    vertices.insert(vertices.end(), mesh.vertices.begin(), mesh.vertices.end());
    indices.insert(indices.end(), mesh.indices.begin(), mesh.indices.end());
  };
  std::vector<fixtures::BodyMesh> bodies(compiled.types.size());
  if (r.has_bodies) bodies = bodies_of(rig, compiled, diagnostics);
  for (fixtures::BodyMesh& body : bodies) number_sheens(body, compiled.heads.size(), sheens);
  std::vector<std::vector<std::uint32_t>> heads(compiled.types.size());
  for (std::uint32_t i = 0; i < compiled.heads.size(); ++i) heads[compiled.heads[i].type].push_back(i);
  for (std::uint32_t t = 0; t < compiled.types.size(); ++t) {
    const fixtures::BodyMesh& body = bodies[t];
    if (body.indices.empty() || heads[t].empty()) continue;
    BodyMeshRow mesh{};
    add_spheres(body, mesh);
    add_boxes(body, ball_of(rig, compiled.sources[t]), boxes);
    mesh.slot_first = static_cast<std::uint32_t>(slots.size());
    mesh.slot_count = static_cast<std::uint32_t>(heads[t].size());
    mesh.level_first = static_cast<std::uint32_t>(levels.size());
    for (fixtures::BodyLevel& level : fixtures::body_levels(body)) {
      r.level_triangles.push_back(static_cast<std::uint32_t>(level.mesh.indices.size() / 3));
      const fixtures::ShellOrder order = fixtures::order_by_shells(level.mesh, FL_PART_DEPTH);
      add(level.mesh, order, 0, level.error_m);
      ++mesh.level_count;
    }
    const std::uint64_t triangles = body.indices.size() / 3;
    for (const std::uint32_t head : heads[t]) {
      slots.push_back(
          {head, static_cast<std::uint32_t>(meshes.size()), static_cast<std::uint32_t>(r.body_triangles), 0});
      r.body_triangles += triangles;
      rounds += (triangles + FL_GROUP_TRIANGLES - 1) / FL_GROUP_TRIANGLES;
    }
    meshes.push_back(mesh);
  }
  number_occluders(compiled, slots);
  r.slot_count = static_cast<std::uint32_t>(slots.size());
  r.mesh_count = static_cast<std::uint32_t>(meshes.size());
  r.draw_count = static_cast<std::uint32_t>(draws.size());
  fixtures::BodyMesh objects;
  ObjectTextures textures;
  if (r.has_bodies) objects = objects_of(rig, diagnostics, object_solids, textures, sheens);
  FL_TRY(make_texture_tables(device, textures, r));
  std::vector<ObjectShellsRow> shells;
  if (!objects.indices.empty()) {
    const fixtures::ShellOrder order = fixtures::order_by_shells(objects, 0);
    shells = object_shells(objects, order);
    add(objects, order, 1, 0);
    r.object_triangles = objects.indices.size() / 3;
    for (const fixtures::BodyVertex& vertex : objects.vertices) {
      const glm::dvec3 at(vertex.position[0], vertex.position[1], vertex.position[2]);
      r.objects.low_m = glm::min(r.objects.low_m, at);
      r.objects.high_m = glm::max(r.objects.high_m, at);
    }
    r.object_draw_count = 1;
  }
  FL_ASSIGN(r.vertices, vk::Buffer::table(device, vertices, VK_BUFFER_USAGE_VERTEX_BUFFER_BIT));
  FL_ASSIGN(r.indices, vk::Buffer::table(device, indices, VK_BUFFER_USAGE_INDEX_BUFFER_BIT));
  FL_ASSIGN(r.slots, vk::Buffer::table(device, slots));
  FL_ASSIGN(r.meshes, vk::Buffer::table(device, meshes));
  FL_ASSIGN(r.body_boxes, vk::Buffer::table(device, boxes));
  FL_ASSIGN(r.body_levels, vk::Buffer::table(device, levels));
  FL_ASSIGN(r.draws, vk::Buffer::table(device, draws, VK_BUFFER_USAGE_INDIRECT_BUFFER_BIT));
  FL_ASSIGN(r.choices, vk::Buffer::table(device, std::vector<std::uint32_t>(slots.size(), FL_CHOICE_NONE)));
  FL_ASSIGN(r.body_spaces, vk::Buffer::table(device, std::vector<BodySpaceRow>(slots.size())));
  FL_ASSIGN(r.body_rounds, vk::Buffer::device_local(device, sizeof(BodyRoundsHead) + rounds * sizeof(BodyRoundRow),
                                                    VK_BUFFER_USAGE_STORAGE_BUFFER_BIT |
                                                        VK_BUFFER_USAGE_INDIRECT_BUFFER_BIT |
                                                        VK_BUFFER_USAGE_TRANSFER_DST_BIT));
  FL_ASSIGN(r.object_shells, vk::Buffer::table(device, shells));
  FL_ASSIGN(r.drawn, vk::Buffer::table(device, std::vector<std::uint32_t>(slots.size(), 0)));
  return {};
}

}  // namespace footlight::render
