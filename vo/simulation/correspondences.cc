#include "correspondences.h"

#include <algorithm>
#include <optional>
#include <string>

#include "gluevo/vo/io/hdf5_file.h"
#include "parallel_for.h"

namespace gluevo::simulation {
namespace {

constexpr int kGrid = 8;  // pixels

/// The columns of a group, row after row.
struct Table {
  std::vector<float> pixel;
  std::vector<float> point;
  std::vector<float> right;
  std::vector<float> next;
};

template <int size>
void Append(const Eigen::Matrix<double, size, 1>& values, std::vector<float>* column) {
  for (const double value : values) column->push_back(static_cast<float>(value));
}

Eigen::Vector2d OrNowhere(const std::optional<Eigen::Vector2d>& pixel) {
  return pixel.value_or(Eigen::Vector2d(-1.0, -1.0));
}

}  // namespace

void WriteCorrespondences(const std::filesystem::path& file, const Renderer& renderer,
                          const SimulatedWorld& world,
                          const std::vector<vo::Rigid3>& world_from_body,
                          const std::vector<int64_t>& times_ns, int threads,
                          const std::function<void()>& checkpoint) {
  const vo::Camera& left = renderer.rig().cameras[0];
  const int count = static_cast<int>(world_from_body.size());
  std::vector<Table> tables(count);
  ParallelFor(count, threads, [&](int i) {
    if (checkpoint) checkpoint();
    Table& table = tables[i];
    const Eye here = renderer.At(world, 0, world_from_body[i]);
    const Eye beside = renderer.At(world, 1, world_from_body[i]);
    const Eye later = renderer.At(world, 0, world_from_body[std::min(i + 1, count - 1)]);
    for (int y = kGrid / 2; y < left.height; y += kGrid) {
      for (int x = kGrid / 2; x < left.width; x += kGrid) {
        const Eigen::Vector2d pixel(x, y);
        const auto point = here.PointAt(pixel);
        if (!point) continue;
        Append<2>(pixel, &table.pixel);
        Append<3>(*point, &table.point);
        Append<2>(OrNowhere(beside.PixelOf(*point)), &table.right);
        Append<2>(OrNowhere(i + 1 < count ? later.PixelOf(*point) : std::nullopt), &table.next);
      }
    }
  });
  vo::internal::H5OutputFile out(file);
  for (int i = 0; i < count; ++i) {
    const std::string group = std::to_string(times_ns[i]);
    const hsize_t rows = tables[i].pixel.size() / 2;
    out.MakeGroup(group, "pixel");
    out.Write(group + "/pixel", {rows, 2}, tables[i].pixel.data());
    out.Write(group + "/point", {rows, 3}, tables[i].point.data());
    out.Write(group + "/right", {rows, 2}, tables[i].right.data());
    out.Write(group + "/next", {rows, 2}, tables[i].next.data());
  }
  out.Finish();
}

}  // namespace gluevo::simulation
