#include "gluevo/vo/simulation/pairs.h"

#include <algorithm>
#include <cstdio>
#include <mutex>
#include <string>
#include <vector>

#include "gluevo/nn/option_error.h"
#include "gluevo/vo/io/hdf5_file.h"
#include "parallel_for.h"
#include "partial_directory.h"
#include "random.h"
#include "training_room.h"

namespace gluevo::simulation {
namespace {

constexpr int kRoomsPerFile = 64;

void Write(const TrainingRoom& room, const std::vector<float>& grid, const PairOptions& options,
           const std::string& group, vo::internal::H5OutputFile* file) {
  const auto height = static_cast<hsize_t>(options.height);
  const auto width = static_cast<hsize_t>(options.width);
  const hsize_t pairs = room.overlap.size();
  const hsize_t points = grid.size() / 2;
  file->MakeGroup(group, "images");
  file->Write(group + "/images", {kViews, height, width}, room.images.data());
  if (options.depth) file->Write(group + "/depth", {kViews, height, width}, room.depth.data());
  file->Write(group + "/world_from_cam", {kViews, 7}, room.world_from_cam.data());
  file->Write(group + "/camera", {kViews, 8}, room.cameras.data());
  file->Write(group + "/boxes", {room.boxes.size() / 7, 7}, room.boxes.data());
  file->Write(group + "/pairs", {pairs, 2}, room.pairs.data());
  file->Write(group + "/overlap", {pairs}, room.overlap.data());
  file->Write(group + "/grid", {points, 2}, grid.data());
  file->Write(group + "/correspondences", {pairs, points, 2}, room.correspondences.data());
}

std::string Numbered(const char* format, int number) {
  char text[32];
  std::snprintf(text, sizeof(text), format, number);
  return text;
}

}  // namespace

void PairOptions::Validate() const {
  const auto check = [](bool good, const std::string& what) {
    if (!good) throw OptionError(what);
  };
  check(rooms >= 1 && rooms <= 1'000'000, "the number of rooms must be 1 to 1000000");
  check(width >= 64 && width <= 4096 && height >= 64 && height <= 4096,
        "the sides of simulated images must be 64 to 4096 pixels (--width, --height)");
  check(threads >= 0 && threads <= 1024, "the number of threads must be 0 (all) to 1024");
}

void SimulatePairs(const PairOptions& options, const std::filesystem::path& directory,
                   const std::function<void(int, int)>& progress) {
  options.Validate();
  const int threads = ThreadCount(options.threads);
  const std::vector<float> grid = GridOf(options);
  PartialDirectory partial(directory, kSimulatedContent);
  std::mutex progress_mutex;
  int done = 0;
  for (int first = 0; first < options.rooms; first += kRoomsPerFile) {
    const int file_number = first / kRoomsPerFile;
    const Renderer renderer(DrawRig(options, Hash(options.seed, 1, file_number)), threads);
    const GridRays rays = RaysOf(grid, renderer.rig());
    std::vector<TrainingRoom> rooms(std::min(kRoomsPerFile, options.rooms - first));
    ParallelFor(static_cast<int>(rooms.size()), threads, [&](int i) {
      rooms[i] = MakeTrainingRoom(options, renderer, rays, Hash(options.seed, 2, first + i));
      const std::lock_guard<std::mutex> lock(progress_mutex);
      if (progress) progress(++done, options.rooms);
    });
    vo::internal::H5OutputFile file(partial.path() / Numbered("rooms_%05d.h5", file_number));
    for (std::size_t i = 0; i < rooms.size(); ++i) {
      Write(rooms[i], grid, options, Numbered("room_%06d", first + static_cast<int>(i)), &file);
    }
    file.Finish();
  }
  partial.Finish();
}

}  // namespace gluevo::simulation
