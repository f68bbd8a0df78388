#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "gluevo/vo/core/trajectory.h"
#include "gluevo/vo/mapping/map_localizer.h"

namespace gluevo::apps {

struct LocalizedFrame {
  std::string name;
  int64_t timestamp_ns = 0;
  std::optional<vo::Localization> result;  ///< Nothing for a frame that could not be read.
};

/// Where a localisation puts what it makes.
struct LocalizationPlaces {
  std::filesystem::path trajectory;
  std::filesystem::path table;
};
LocalizationPlaces PlacesIn(const std::filesystem::path& folder);

/// Throws Error where a file is at one of the places that no localisation made.
void CheckReplacesOnlyLocalization(const LocalizationPlaces& places);

/// Writes the poses of the frames that were found in the map's largest part, and a line for every
/// frame; docs/OUTPUTS.md has the columns. Throws Error where a file cannot be written.
void WriteLocalization(const LocalizationPlaces& places, const std::vector<LocalizedFrame>& frames,
                       const vo::PlaceMap& map);

/// A line or two for people; with the error of the trajectory where there is truth.
std::string SummaryOf(const std::vector<LocalizedFrame>& frames, const vo::PlaceMap& map,
                      const std::optional<vo::Trajectory>& groundtruth);

}  // namespace gluevo::apps
