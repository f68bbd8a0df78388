#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "gluevo/nn/features.h"
#include "gluevo/vo/io/hdf5_pointer.h"

namespace gluevo::vo {

// HDF5 files of features and matches in the layout of hloc (Hierarchical-Localization,
// github.com/cvg/Hierarchical-Localization), so that its tools read ours and ours theirs.
//
// features.h5 has a group an image, called as the image (slashes in the name nest groups):
//   keypoints    N x 2  x, y in pixels of the original image, the centre of the top-left pixel at
//                       (0, 0), as in nn::Features. hloc stores the same: it scales keypoints with
//                       that convention and adds 0.5 only when it hands them to COLMAP.
//   scores       N
//   descriptors  D x N  (nn::Features has N x D)
//   image_size   2      width, height of the original image
// matches.h5 has a group "NAME0/NAME1" a pair, slashes inside the names being '-':
//   matches0          N0  index in image 1, or -1
//   matching_scores0  N0  confidence, 0 where there is no match
//
// We write 32-bit floats and integers (image_size: 64 bits, as hloc). hloc itself writes 16-bit
// ones by default: every width is read.
//
// Objects of these classes may be used from several threads, but not one object from two at a time.

/// Writes features.h5 image by image, beside its place; Finish() puts it there. Without Finish()
/// nothing is left. All members throw Error naming the file and the object.
class FeatureWriter {
 public:
  explicit FeatureWriter(const std::filesystem::path& path);

  /// Throws Error for a name that is empty, there already, or has empty, "." or ".." parts, and for
  /// features whose members' sizes disagree.
  void Add(const std::string& image, const nn::Features& features);
  /// Closes the file and gives it its name. Nothing can be added afterwards.
  void Finish();

 private:
  internal::H5OutputPointer file_;
};

/// Reads features.h5, ours or hloc's.
class FeatureReader {
 public:
  /// Throws Error where the file is not there or is no HDF5 file.
  explicit FeatureReader(const std::filesystem::path& path);

  /// The names of all groups with a dataset "keypoints", sorted.
  const std::vector<std::string>& images() const { return images_; }
  bool Has(const std::string& image) const;
  /// Throws Error naming the file and the dataset for images and datasets that are not there,
  /// shapes that disagree, values that are not finite, sizes that are not positive, and more than
  /// 2^20 keypoints or 2^28 descriptor values.
  nn::Features Read(const std::string& image) const;

 private:
  internal::H5InputPointer file_;
  std::vector<std::string> images_;
};

/// Writes matches.h5 pair by pair, as FeatureWriter does.
class MatchWriter {
 public:
  explicit MatchWriter(const std::filesystem::path& path);

  void Add(const std::string& image0, const std::string& image1, const nn::Matches& matches);
  void Finish();

 private:
  internal::H5OutputPointer file_;
};

/// Reads matches.h5, ours or hloc's.
class MatchReader {
 public:
  explicit MatchReader(const std::filesystem::path& path);

  /// The stored pairs, sorted; slashes inside the names are '-'.
  const std::vector<std::pair<std::string, std::string>>& pairs() const { return pairs_; }
  /// Whether the pair is there in this order; names with slashes or with '-' in their place.
  bool Has(const std::string& image0, const std::string& image1) const;
  /// Throws Error as FeatureReader::Read does, and for matches below -1. Whether they are below
  /// the number of keypoints of image 1 only the caller can know.
  nn::Matches Read(const std::string& image0, const std::string& image1) const;

 private:
  internal::H5InputPointer file_;
  std::vector<std::pair<std::string, std::string>> pairs_;
};

}  // namespace gluevo::vo
