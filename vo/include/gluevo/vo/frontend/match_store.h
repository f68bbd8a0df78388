#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <unordered_map>
#include <vector>

#include "gluevo/vo/frontend/frontend.h"
#include "gluevo/vo/geometry/stereo_rig.h"
#include "gluevo/vo/io/hdf5_pointer.h"

namespace gluevo::vo {

// The matches of a run in one HDF5 file ("store and replay", Yoon and Park), so that the estimator
// can run on them again without images and without networks.
//
//   attributes        format "gluevo matches", version "2", method
//   options, weights  groups whose attributes are the options and the weights of the run
//   rig            2 x 22    a camera: width, height, fx, fy, cx, cy, model of distortion (number
//                            of vo::Distortion), its 8 coefficients (5 in version "1", 2 x 19),
//                            body_from_cam as quaternion (x y z w) and translation (metres)
//   timestamps_ns  F
//   left_out_ns    the times of frames that could not be read; absent where there were none
//   frames/000000  and so on, a group a frame; row i of every dataset belongs to the same track:
//     track_ids             N      the same in all frames that see the point
//     left_pixels           N x 2  in this frame's left image
//     previous_left_pixels  N x 2  in the left image of the frame before, NaN for what it lacks
//     right_pixels          N x 2  in this frame's right image, NaN where there is no match
//     left, right           N x 2  the same without distortion, on the normalised planes z = 1
//     tracking_confidences, stereo_confidences  N
//
// Coordinates are 64-bit floats: what is read is bit for bit what was written.

/// How the matches of a run were made. For people, and for a replay's records.
struct RunRecord {
  std::string method;
  std::map<std::string, std::string> options;  ///< Values by name.
  std::map<std::string, std::string> weights;  ///< Names and checksums of the networks' weights.
};

/// Writes frame by frame beside the file's place; Finish() puts it there. Without Finish() nothing
/// is left. All members throw Error naming the file.
class MatchStoreWriter {
 public:
  MatchStoreWriter(const std::filesystem::path& path, const StereoRig& rig,
                   const RunRecord& record);

  /// The next frame of the run: what the pose was estimated from.
  void Add(const TrackedFrame& frame);
  /// A frame of the data set that could not be read: a replay leaves it out, too.
  void LeaveOut(int64_t timestamp_ns) { left_out_ns_.push_back(timestamp_ns); }
  /// Closes the file and gives it its name. Nothing can be added afterwards.
  void Finish();

 private:
  internal::H5OutputPointer file_;
  std::vector<int64_t> timestamps_ns_, left_out_ns_;
  std::unordered_map<int64_t, Eigen::Vector2d> previous_left_;  // pixels, by track
};

/// Reads such a file. Not from two threads at a time.
class MatchStoreReader {
 public:
  /// Throws Error where the file is not there, is no HDF5 file, or holds something else.
  explicit MatchStoreReader(const std::filesystem::path& path);

  const std::filesystem::path& path() const { return path_; }
  const RunRecord& record() const { return record_; }
  const StereoRig& rig() const { return rig_; }  ///< Without the name of its body frame.
  const std::vector<int64_t>& timestamps_ns() const { return timestamps_ns_; }
  /// Times of frames between them that could not be read.
  const std::vector<int64_t>& left_out_ns() const { return left_out_ns_; }

  /// Frame `index` of timestamps_ns(). Throws Error naming the dataset for shapes that disagree,
  /// left coordinates or confidences that are not finite, and tracks that are there twice.
  TrackedFrame Read(std::size_t index) const;

 private:
  StereoRig ReadRig(std::size_t columns) const;

  std::filesystem::path path_;
  internal::H5InputPointer file_;
  RunRecord record_;
  StereoRig rig_;
  std::vector<int64_t> timestamps_ns_, left_out_ns_;
};

/// A stored run as a front end: gives its frames one after another and looks at no image.
class ReplayFrontEnd final : public FrontEnd {
 public:
  /// The frames at `timestamps_ns` are to be replayed: those of the stored run, from its first on.
  /// Throws Error with what differs where the store was made with another rig or of other frames.
  ReplayFrontEnd(MatchStoreReader store, const StereoRig& rig,
                 const std::vector<int64_t>& timestamps_ns);
  /// Throws Error for a frame of another time than the next one to be replayed.
  TrackedFrame Track(const StereoFrame& frame) override;

 private:
  MatchStoreReader store_;
  std::size_t next_ = 0;
};

}  // namespace gluevo::vo
