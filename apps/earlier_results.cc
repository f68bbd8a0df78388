#include "earlier_results.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <system_error>

#include "distinct_outputs.h"
#include "gluevo/nn/error.h"
#include "gluevo/nn/replaced_file.h"
#include "gluevo/vo/frontend/match_store.h"
#include "gluevo/vo/io/whole_file.h"

namespace gluevo::apps {
namespace {

namespace fs = std::filesystem;

// The ending of an earlier run's trajectories; nothing where there was none.
std::optional<std::string> EarlierEnding(const fs::path& folder) {
  std::error_code code;
  const fs::path file = folder / "metrics.json";
  if (!fs::is_regular_file(file, code)) {
    return std::nullopt;
  }
  const auto metrics =
      nlohmann::json::parse(vo::ReadWholeFile(file), nullptr, /*allow_exceptions=*/false);
  if (!metrics.is_object() || !metrics.contains("frames") || !metrics.contains("segments") ||
      !metrics.contains("options") || !metrics["options"].is_object()) {
    return std::nullopt;
  }
  const auto format = metrics["options"].find("trajectory-format");
  const bool is_known = format != metrics["options"].end() &&
                        (*format == "tum" || *format == "euroc" || *format == "kitti");
  return TrajectoryEnding(is_known ? format->get<std::string>() : "tum");
}

void CheckStore(const fs::path& matches) {
  std::error_code code;
  if (!fs::is_regular_file(matches, code) || fs::is_empty(matches, code)) {
    return;
  }
  try {
    const vo::MatchStoreReader reader(matches);
  } catch (const Error&) {
    throw Error(matches.string() +
                ": cannot be written: a file is there that is no file of --save-matches");
  }
}

}  // namespace

std::vector<fs::path> StaleTrajectories(const RunPlaces& places) {
  const std::optional<std::string> earlier = EarlierEnding(places.folder);
  std::vector<fs::path> stale;
  if (!earlier) {
    return stale;
  }
  const std::vector<fs::path> files = OutputFiles(places);
  for (const char* const name : {"trajectory", "keyframes", "imu_rate", "trajectory_optimized"}) {
    const fs::path file = places.folder / (name + *earlier);
    if (std::find(files.begin(), files.end(), file) == files.end()) {
      stale.push_back(file);
    }
  }
  return stale;
}

void CheckReplacesOnlyResults(const RunPlaces& places, const fs::path& matches,
                              const fs::path& dataset) {
  CheckStore(matches);
  nn::CheckReplacesOnly(places.saved_map, "gluevo map", "a map of gluevo");
  const auto check = [&](const fs::path& file, bool is_result) {
    if (!is_result && IsFileBelow(file, dataset)) {
      throw Error(file.string() + ": cannot be written: is a file of the data set " +
                  dataset.string() + " that no run made, which the output would replace");
    }
  };
  // Of these one says what they are.
  const std::optional<std::string> earlier = EarlierEnding(places.folder);
  const std::string ending = TrajectoryEnding(places.trajectory_format);
  for (const fs::path& file : OutputFiles(places)) {
    const bool is_trajectory = file.extension() == ending && file.filename() != "covariance.csv";
    check(file, earlier && (!is_trajectory || ending == *earlier));
  }
  if (places.map.empty()) {
    return;
  }
  for (const fs::path& file : MapFiles(places)) {
    check(file, nn::HasMark(file, "world frame, metres"));
  }
  std::error_code code;
  const auto model = [&](int segment) { return ColmapFolder(places) / std::to_string(segment); };
  for (int i = 0; fs::is_directory(model(i), code); ++i) {
    const bool is_result = nn::HasMark(model(i) / "cameras.txt", "# CAMERA_ID, MODEL");
    for (const char* const name : {"cameras.txt", "images.txt", "points3D.txt"}) {
      check(model(i) / name, is_result);
    }
  }
}

}  // namespace gluevo::apps
