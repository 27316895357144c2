// The motion as glTF 2.0 (Khronos, glTF 2.0 Specification): one buffer, a node a body, cubic splines.
#include <algorithm>
#include <cstdint>
#include <nlohmann/json.hpp>

#include "perp/version.hpp"
#include "perp/view/pictures.hpp"
#include "view/drawing.hpp"
#include "view/encode.hpp"
#include "view/keyframes.hpp"
#include "view/mesh.hpp"

namespace perp {
namespace {

using nlohmann::json;

constexpr int float_type = 5126, unsigned_type = 5125;  // glTF's componentType
constexpr int vertex_buffer = 34962, index_buffer = 34963;

/// The one buffer of a file and the views and accessors into it.
class Buffer {
 public:
  /// `type` SCALAR, VEC3, VEC4; with `bounds` the accessor has min and max, which positions and times need.
  int add(const std::vector<float>& values, const char* type, int width, bool bounds, int target = 0) {
    json accessor = begin(values.data(), values.size() * sizeof(float),
                          values.size() / static_cast<std::size_t>(width), target);
    accessor["componentType"] = float_type;
    accessor["type"] = type;
    if (bounds) {
      std::vector<float> low(values.begin(), values.begin() + width), high = low;
      for (std::size_t i = 0; i < values.size(); ++i) {
        const std::size_t k = i % static_cast<std::size_t>(width);
        low[k] = std::min(low[k], values[i]), high[k] = std::max(high[k], values[i]);
      }
      accessor["min"] = low, accessor["max"] = high;
    }
    return end(std::move(accessor));
  }
  int add_indices(const std::vector<int>& values) {
    std::vector<std::uint32_t> whole(values.begin(), values.end());
    json accessor = begin(whole.data(), whole.size() * sizeof(std::uint32_t), whole.size(), index_buffer);
    accessor["componentType"] = unsigned_type;
    accessor["type"] = "SCALAR";
    return end(std::move(accessor));
  }
  void put_into(json& file) {
    if (bytes_.empty()) return;  // glTF has no empty buffers
    file["buffers"] = {
        {{"byteLength", bytes_.size()},
         {"uri", "data:application/octet-stream;base64," + base64(bytes_.data(), bytes_.size())}}};
    file["bufferViews"] = std::move(views_);
    file["accessors"] = std::move(accessors_);
  }

 private:
  json begin(const void* data, std::size_t size, std::size_t count, int target) {
    json view{{"buffer", 0}, {"byteOffset", bytes_.size()}, {"byteLength", size}};
    if (target != 0) view["target"] = target;
    const auto* first = static_cast<const char*>(data);
    bytes_.insert(bytes_.end(), first, first + size);
    views_.push_back(std::move(view));
    return {{"bufferView", views_.size() - 1}, {"count", count}};
  }
  int end(json accessor) {
    accessors_.push_back(std::move(accessor));
    return static_cast<int>(accessors_.size()) - 1;
  }
  std::vector<char> bytes_;
  json views_ = json::array(), accessors_ = json::array();
};

std::vector<float> flat(const std::vector<Vector3>& points) {
  std::vector<float> out;
  for (const Vector3& p : points)
    for (const double x : p) out.push_back(static_cast<float>(x));
  return out;
}

/// A key of a cubic spline: slope on arriving, value, slope on leaving.
template <class V>
void add_key(const V& in, const V& value, const V& out, std::vector<float>& keys) {
  for (const V* v : {&in, &value, &out})
    for (int i = 0; i < v->size(); ++i) keys.push_back(static_cast<float>((*v)[i]));
}

/// glTF's order x, y, z, w is Eigen's.
Eigen::Vector4d turning_rate(const Quaternion& q, const Vector3& w) {
  return 0.5 * (Quaternion(0, w.x(), w.y(), w.z()) * q).coeffs();
}

/// Translation and rotation of a body over time as two channels. Two rows at one time are one key whose slopes differ.
void add_motion(const DrawnBody& body, int node, double t_0, double radius, Buffer& buffer, json& animation) {
  constexpr double fine = 1e-5;  // of the scene, and in rad
  const Keyframes keys = thinned(body.t, body.moments, fine * radius, fine);
  std::vector<float> times, translations, rotations;
  Quaternion last = Quaternion::Identity();
  for (std::size_t k = 0; k < keys.rows.size(); ++k) {
    const auto row = [&](std::size_t i) { return static_cast<std::size_t>(keys.rows[i]); };
    std::size_t leaving = k;
    const auto time = [&](std::size_t i) { return static_cast<float>(body.t[row(i)] - t_0); };
    while (leaving + 1 < keys.rows.size() && time(leaving + 1) <= time(k))
      ++leaving;  // equal in single precision
    const Moment &in = body.moments[row(k)], &out = body.moments[row(leaving)];
    Quaternion q = out.X.q;
    if (q.dot(last) < 0) q.coeffs() = -q.coeffs();
    last = q;
    times.push_back(time(k));
    add_key<Vector3>(in.V.v, out.X.p, out.V.v, translations);
    add_key<Eigen::Vector4d>(turning_rate(q, in.V.w), q.coeffs(), turning_rate(q, out.V.w), rotations);
    k = leaving;
  }
  const int input = buffer.add(times, "SCALAR", 1, true);
  const auto channel = [&](const std::vector<float>& values, const char* type, int width, const char* path) {
    animation["samplers"].push_back({{"input", input},
                                     {"output", buffer.add(values, type, width, false)},
                                     {"interpolation", "CUBICSPLINE"}});
    animation["channels"].push_back(
        {{"sampler", animation["samplers"].size() - 1}, {"target", {{"node", node}, {"path", path}}}});
  };
  channel(translations, "VEC3", 3, "translation");
  channel(rotations, "VEC4", 4, "rotation");
}

json material(const DrawnBody& body) {
  constexpr double colours[][3] = {{0, .17, .45},   {.79, .35, 0}, {0, .34, .17}, {.6, .19, .39},
                                   {.09, .46, .81}, {.67, .11, 0}, {.48, .39, 0}, {.18, .18, .18}};
  const auto& c = colours[static_cast<std::size_t>(body.colour) % std::size(colours)];
  const bool still = body.kind == "ground" || body.kind == "prescribed";
  const json colour = still ? json{.35, .38, .42, 1} : json{c[0], c[1], c[2], 1};
  return {{"name", body.name},
          {"doubleSided", true},
          {"pbrMetallicRoughness",
           {{"baseColorFactor", colour}, {"metallicFactor", 0}, {"roughnessFactor", .7}}}};
}

}  // namespace

std::string gltf_of(const RecordedRun& run) {
  const Drawing drawing = drawing_of(run);
  Buffer buffer;
  json file{{"asset", {{"version", "2.0"}, {"generator", "perp " + std::string(version)}}},
            {"scene", 0},
            {"nodes", json::array()}};
  json animation{{"name", run.name}, {"samplers", json::array()}, {"channels", json::array()}};
  // the run's axes under glTF's, whose y is up
  const Quaternion upright = Quaternion::FromTwoVectors(drawing.up, Vector3::UnitY());
  file["nodes"].push_back(
      {{"name", "world"}, {"rotation", {upright.x(), upright.y(), upright.z(), upright.w()}}});
  file["scenes"] = {{{"name", run.name}, {"nodes", {0}}}};
  for (const DrawnBody& body : drawing.bodies) {
    const int node = static_cast<int>(file["nodes"].size());
    const Moment& m = body.moments.front();
    json described{{"name", body.name},
                   {"translation", {m.X.p.x(), m.X.p.y(), m.X.p.z()}},
                   {"rotation", {m.X.q.x(), m.X.q.y(), m.X.q.z(), m.X.q.w()}}};
    if (!body.solids.empty()) {
      json primitives = json::array();
      for (const Solid& solid : body.solids) {
        const Mesh mesh = mesh_of(solid, 1.6 * drawing.radius, 0.012 * drawing.radius);
        primitives.push_back({{"attributes",
                               {{"POSITION", buffer.add(flat(mesh.vertices), "VEC3", 3, true, vertex_buffer)},
                                {"NORMAL", buffer.add(flat(mesh.normals), "VEC3", 3, false, vertex_buffer)}}},
                              {"indices", buffer.add_indices(mesh.triangles)},
                              {"material", file.contains("materials") ? file["materials"].size() : 0}});
      }
      file["materials"].push_back(material(body));
      described["mesh"] = file.contains("meshes") ? file["meshes"].size() : 0;
      file["meshes"].push_back({{"name", body.name}, {"primitives", std::move(primitives)}});
    }
    file["nodes"].push_back(std::move(described));
    file["nodes"][0]["children"].push_back(node);
    if (body.moments.size() > 1) add_motion(body, node, run.t.front(), drawing.radius, buffer, animation);
  }
  if (!animation["channels"].empty()) file["animations"] = {std::move(animation)};
  buffer.put_into(file);
  return file.dump(-1, ' ', false, json::error_handler_t::replace);
}

}  // namespace perp
