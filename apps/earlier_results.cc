#include "earlier_results.h"

#include <nlohmann/json.hpp>
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

bool HasMetrics(const fs::path& folder) {
  std::error_code code;
  const fs::path file = folder / "metrics.json";
  if (!fs::is_regular_file(file, code)) {
    return false;
  }
  const auto metrics =
      nlohmann::json::parse(vo::ReadWholeFile(file), nullptr, /*allow_exceptions=*/false);
  return metrics.contains("frames") && metrics.contains("segments") && metrics.contains("options");
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
  // Of these one says what it is.
  const bool is_rerun = HasMetrics(places.folder);
  for (const fs::path& file : OutputFiles(places)) {
    check(file, is_rerun);
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
