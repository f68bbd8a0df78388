#pragma once

#include <filesystem>
#include <iosfwd>
#include <string>
#include <vector>

#include "gluevo/vo/io/dataset.h"
#include "gluevo/vo/mapping/map_culling.h"
#include "run_frames.h"
#include "run_metrics.h"

namespace gluevo::apps {

/// Where a run puts what it makes.
struct RunPlaces {
  std::filesystem::path folder;
  std::string trajectory_format = "tum";  ///< tum, euroc or kitti
  std::filesystem::path map;              ///< Empty: none.
  std::filesystem::path saved_map;        ///< Of places; empty: none.
  vo::MapCullingOptions culling;          ///< Of that map.
  bool has_loops = false;                 ///< And so a trajectory that fits them.
  bool has_imu_rate = false;              ///< A trajectory with a pose for every inertial reading.
};

/// What a run puts into its folder, the map apart.
std::vector<std::filesystem::path> OutputFiles(const RunPlaces& places);

/// The map's files that have one name each, its models for COLMAP apart; none without a map.
std::vector<std::filesystem::path> MapFiles(const RunPlaces& places);

/// Where the map's models for COLMAP go, a folder each.
std::filesystem::path ColmapFolder(const RunPlaces& places);

/// Throws Error where a file in the folder or the map's, which must be there, could not be put in
/// its place.
void CheckPlaces(const RunPlaces& places);

/// Writes the map of places to `places.saved_map`: all that the run keeps so far, its key frames at
/// these poses. Throws Error where it cannot be written.
void WritePlaces(const RunPlaces& places, const RunRecords& records,
                 const std::vector<vo::Rigid3>& keyframe_poses, const vo::MapFeatures& features);

/// Ends a run: writes all that it makes, and tells `out` how it went. Where one file cannot be
/// written the others are. Throws Error for what ended the run early, where something did, else for
/// the first file that could not be written. `name`: the data set as the user named it.
void FinishRun(const RunPlaces& places, const vo::Dataset& dataset, const std::string& name,
               RunRecords& records, const RunMetrics::Context& context, std::ostream& out);

}  // namespace gluevo::apps
