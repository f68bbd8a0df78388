#pragma once

#include <hdf5.h>

#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "gluevo/vo/io/hdf5_pointer.h"

namespace gluevo::nn {
class UnfinishedFile;
}  // namespace gluevo::nn

namespace gluevo::vo::internal {

class H5OutputStorage;

/// While it lives, HDF5 prints nothing to stderr and no other thread of ours is in HDF5 (which need
/// not be built for threads).
class H5Session {
 public:
  H5Session();
  ~H5Session();
  H5Session(const H5Session&) = delete;
  H5Session& operator=(const H5Session&) = delete;

 private:
  static std::recursive_mutex& Mutex();
  std::lock_guard<std::recursive_mutex> lock_;
  H5E_auto2_t report_ = nullptr;
  void* report_data_ = nullptr;
};

/// An HDF5 identifier and what closes it. Close and destroy it within an H5Session.
class H5Handle {
 public:
  using Closer = herr_t (*)(hid_t);
  H5Handle() = default;
  H5Handle(hid_t id, Closer close) : id_(id), close_(close) {}
  H5Handle(H5Handle&& other) noexcept;
  H5Handle& operator=(H5Handle&& other) noexcept;
  ~H5Handle() { Close(); }

  hid_t id() const { return id_; }
  bool valid() const { return id_ >= 0; }
  /// False where HDF5 could not (data could not be flushed).
  bool Close();

 private:
  hid_t id_ = H5I_INVALID_HID;
  Closer close_ = nullptr;
};

/// What HDF5 says of its last failure on this thread, most specific first cause; " (...)" or "".
std::string H5Reason();

/// A new HDF5 file, filled beside its place and renamed when whole. The same data in the same order
/// give the same bytes. Throws Error naming file and object, also where the disk is full: then
/// nothing is left of it, and HDF5 is none the worse.
class H5OutputFile {
 public:
  explicit H5OutputFile(const std::filesystem::path& path);
  ~H5OutputFile();
  H5OutputFile(const H5OutputFile&) = delete;
  H5OutputFile& operator=(const H5OutputFile&) = delete;

  /// A new group; the groups above it are made where missing. Throws Error where it exists with a
  /// dataset called `dataset_of_it` in it, or cannot be made.
  void MakeGroup(const std::string& group, const std::string& dataset_of_it);
  void Write(const std::string& dataset, const std::vector<hsize_t>& shape, const float* values);
  void Write(const std::string& dataset, const std::vector<hsize_t>& shape, const double* values);
  void Write(const std::string& dataset, const std::vector<hsize_t>& shape, const int32_t* values);
  void Write(const std::string& dataset, const std::vector<hsize_t>& shape, const int64_t* values);
  void Write(const std::string& dataset, const std::vector<hsize_t>& shape, const uint8_t* values);
  /// Texts by name, as attributes of a group that is there ("/": the file).
  void WriteTexts(const std::string& group, const std::map<std::string, std::string>& texts);
  void Finish();

 private:
  void Write(const std::string& dataset, const std::vector<hsize_t>& shape, hid_t file_type,
             hid_t memory_type, const void* values);
  void CheckOpen() const;
  /// Why the last call failed, to end a message with.
  std::string Reason() const;

  std::filesystem::path path_;
  std::unique_ptr<nn::UnfinishedFile> unfinished_;
  std::unique_ptr<H5OutputStorage> storage_;
  H5Handle file_;  // Goes before what it is stored in.
};

/// An HDF5 file to read. Throws Error naming file and object.
class H5InputFile {
 public:
  explicit H5InputFile(const std::filesystem::path& path);
  ~H5InputFile();
  H5InputFile(const H5InputFile&) = delete;
  H5InputFile& operator=(const H5InputFile&) = delete;

  /// Whether there is something of this name, which has no slash.
  bool Has(const std::string& name) const;
  /// The groups that hold something called `dataset`, by their full names without a leading slash,
  /// sorted.
  std::vector<std::string> GroupsWith(const std::string& dataset) const;
  /// The extents of a dataset of rank `rank`, each at most `largest`.
  std::vector<int64_t> ShapeOf(const std::string& dataset, int rank, int64_t largest) const;
  /// All values, whatever the width of the stored floats or integers; throws for those that are not
  /// finite.
  std::vector<float> ReadFloats(const std::string& dataset) const;
  /// The same; throws for stored types other than integers, and values outside of 32 bits.
  std::vector<int> ReadIntegers(const std::string& dataset) const;
  /// The same in full width, infinities and NaN too.
  std::vector<double> ReadDoubles(const std::string& dataset) const;
  std::vector<int64_t> ReadLongIntegers(const std::string& dataset) const;
  /// All attributes of a group that are texts, by name.
  std::map<std::string, std::string> ReadTexts(const std::string& group) const;

  /// "FILE: WHAT NAME", to begin a message with.
  std::string Place(const std::string& name) const;

 private:
  H5Handle Open(const std::string& dataset) const;
  template <typename Value>
  std::vector<Value> ReadAll(const H5Handle& opened, const std::string& dataset,
                             hid_t memory_type) const;

  std::filesystem::path path_;
  H5Handle file_;
};

H5OutputPointer CreateH5(const std::filesystem::path& path);
H5InputPointer OpenH5(const std::filesystem::path& path);

}  // namespace gluevo::vo::internal
