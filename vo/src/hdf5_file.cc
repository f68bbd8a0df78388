#include "hdf5_file.h"

#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string_view>
#include <system_error>
#include <utility>

#include "gluevo/nn/error.h"

namespace gluevo::vo::internal {
namespace {

/// HDF5 walks through what it calls an error stack; the innermost entry tells the cause.
herr_t KeepFirst(unsigned position, const H5E_error2_t* error, void* text) {
  if (position == 0 && error->desc != nullptr) *static_cast<std::string*>(text) = error->desc;
  return 0;
}

int64_t CountOf(const H5Handle& space) {
  return static_cast<int64_t>(H5Sget_simple_extent_npoints(space.id()));
}

}  // namespace

std::recursive_mutex& H5Session::Mutex() {
  static std::recursive_mutex mutex;
  return mutex;
}

H5Session::H5Session() : lock_(Mutex()) {
  H5Eget_auto2(H5E_DEFAULT, &report_, &report_data_);
  H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
}

H5Session::~H5Session() { H5Eset_auto2(H5E_DEFAULT, report_, report_data_); }

H5Handle::H5Handle(H5Handle&& other) noexcept
    : id_(std::exchange(other.id_, H5I_INVALID_HID)), close_(other.close_) {}

H5Handle& H5Handle::operator=(H5Handle&& other) noexcept {
  if (this != &other) {
    Close();
    id_ = std::exchange(other.id_, H5I_INVALID_HID);
    close_ = other.close_;
  }
  return *this;
}

bool H5Handle::Close() {
  const hid_t id = std::exchange(id_, H5I_INVALID_HID);
  return id < 0 || close_(id) >= 0;
}

std::string H5Reason() {
  std::string text;
  H5Ewalk2(H5E_DEFAULT, H5E_WALK_UPWARD, KeepFirst, &text);
  return text.empty() ? "" : " (" + text + ")";
}

H5OutputFile::H5OutputFile(const std::filesystem::path& path) : path_(path), beside_(path) {
  const H5Session session;
  // The process id keeps two programs that write the same file apart.
  beside_ += ".unfinished-" + std::to_string(::getpid());
  file_ = H5Handle(H5Fcreate(beside_.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT), H5Fclose);
  if (!file_.valid()) throw Error(path_.string() + ": cannot be written" + H5Reason());
}

H5OutputFile::~H5OutputFile() {
  const H5Session session;
  if (!file_.valid()) return;
  file_.Close();
  std::error_code ignored;
  std::filesystem::remove(beside_, ignored);
}

void H5OutputFile::CheckOpen() const {
  if (!file_.valid()) throw Error(path_.string() + ": is finished, nothing can be added to it");
}

void H5OutputFile::MakeGroup(const std::string& group, const std::string& dataset_of_it) {
  const H5Session session;
  CheckOpen();
  const std::string place = path_.string() + ": group " + Quoted(group);
  // A group may be there as the parent of another: image "a" after image "a/b".
  std::size_t end = 0;
  bool exists = true;
  while (exists && end != std::string::npos) {
    end = group.find('/', end + 1);
    exists = H5Lexists(file_.id(), group.substr(0, end).c_str(), H5P_DEFAULT) > 0;
  }
  if (exists) {
    const H5Handle old(H5Gopen2(file_.id(), group.c_str(), H5P_DEFAULT), H5Gclose);
    if (!old.valid() || H5Lexists(old.id(), dataset_of_it.c_str(), H5P_DEFAULT) != 0) {
      throw Error(place + " is written twice");
    }
    return;
  }
  const H5Handle parents(H5Pcreate(H5P_LINK_CREATE), H5Pclose);
  const H5Handle timeless(H5Pcreate(H5P_GROUP_CREATE), H5Pclose);
  H5Pset_create_intermediate_group(parents.id(), 1);
  H5Pset_obj_track_times(timeless.id(), false);
  const H5Handle made(
      H5Gcreate2(file_.id(), group.c_str(), parents.id(), timeless.id(), H5P_DEFAULT), H5Gclose);
  if (!made.valid()) throw Error(place + " cannot be written" + H5Reason());
}

void H5OutputFile::Write(const std::string& dataset, const std::vector<hsize_t>& shape,
                         const float* values) {
  Write(dataset, shape, H5T_IEEE_F32LE, H5T_NATIVE_FLOAT, values);
}

void H5OutputFile::Write(const std::string& dataset, const std::vector<hsize_t>& shape,
                         const int32_t* values) {
  Write(dataset, shape, H5T_STD_I32LE, H5T_NATIVE_INT32, values);
}

void H5OutputFile::Write(const std::string& dataset, const std::vector<hsize_t>& shape,
                         const int64_t* values) {
  Write(dataset, shape, H5T_STD_I64LE, H5T_NATIVE_INT64, values);
}

void H5OutputFile::Write(const std::string& dataset, const std::vector<hsize_t>& shape,
                         const double* values) {
  Write(dataset, shape, H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE, values);
}

void H5OutputFile::Write(const std::string& dataset, const std::vector<hsize_t>& shape,
                         const uint8_t* values) {
  Write(dataset, shape, H5T_STD_U8LE, H5T_NATIVE_UINT8, values);
}

void H5OutputFile::Write(const std::string& dataset, const std::vector<hsize_t>& shape,
                         hid_t file_type, hid_t memory_type, const void* values) {
  const H5Session session;
  CheckOpen();
  const H5Handle space(H5Screate_simple(static_cast<int>(shape.size()), shape.data(), shape.data()),
                       H5Sclose);
  const H5Handle timeless(H5Pcreate(H5P_DATASET_CREATE), H5Pclose);
  H5Pset_obj_track_times(timeless.id(), false);
  H5Handle made(H5Dcreate2(file_.id(), dataset.c_str(), file_type, space.id(), H5P_DEFAULT,
                           timeless.id(), H5P_DEFAULT),
                H5Dclose);
  const bool empty = std::find(shape.begin(), shape.end(), 0U) != shape.end();
  if (!made.valid() ||
      (!empty && H5Dwrite(made.id(), memory_type, H5S_ALL, H5S_ALL, H5P_DEFAULT, values) < 0) ||
      !made.Close()) {
    throw Error(path_.string() + ": dataset " + Quoted(dataset) + " cannot be written" +
                H5Reason());
  }
}

void H5OutputFile::Finish() {
  const H5Session session;
  CheckOpen();
  const bool flushed = H5Fflush(file_.id(), H5F_SCOPE_GLOBAL) >= 0;
  const std::string reason = flushed ? "" : H5Reason();
  const bool closed = file_.Close();
  std::error_code code;
  if (flushed && closed) {
    std::filesystem::rename(beside_, path_, code);
    if (!code) return;
  }
  std::error_code ignored;
  std::filesystem::remove(beside_, ignored);
  throw Error(path_.string() + ": cannot be written" + (code ? ": " + code.message() : reason));
}

H5InputFile::H5InputFile(const std::filesystem::path& path) : path_(path) {
  const H5Session session;
  std::error_code code;
  if (!std::filesystem::is_regular_file(path, code)) {
    throw Error(path.string() + ": no such file");
  }
  file_ = H5Handle(H5Fopen(path.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT), H5Fclose);
  if (!file_.valid()) {
    throw Error(path.string() + ": is no readable HDF5 file" + H5Reason());
  }
}

H5InputFile::~H5InputFile() {
  const H5Session session;
  file_.Close();
}

std::string H5InputFile::Place(const std::string& name) const {
  return path_.string() + ": " + Quoted(name);
}

std::vector<std::string> H5InputFile::GroupsWith(const std::string& dataset) const {
  struct Search {
    std::string ending;
    std::vector<std::string> groups;
  };
  const H5Session session;
  Search search{"/" + dataset, {}};
  const H5L_iterate_t visit = [](hid_t, const char* name, const H5L_info_t*, void* data) -> herr_t {
    // HDF5 is C: nothing may be thrown through it.
    try {
      auto* const found = static_cast<Search*>(data);
      const std::string_view path(name);
      if (path.ends_with(found->ending)) {
        found->groups.emplace_back(path.substr(0, path.size() - found->ending.size()));
      }
      return 0;
    } catch (...) {
      return -1;
    }
  };
  if (H5Lvisit(file_.id(), H5_INDEX_NAME, H5_ITER_INC, visit, &search) < 0) {
    throw Error(path_.string() + ": cannot be listed" + H5Reason());
  }
  std::sort(search.groups.begin(), search.groups.end());
  return search.groups;
}

H5Handle H5InputFile::Open(const std::string& dataset) const {
  H5Handle opened(H5Dopen2(file_.id(), dataset.c_str(), H5P_DEFAULT), H5Dclose);
  if (!opened.valid()) throw Error(Place(dataset) + " is no readable dataset" + H5Reason());
  return opened;
}

std::vector<int64_t> H5InputFile::ShapeOf(const std::string& dataset, int rank,
                                          int64_t largest) const {
  const H5Session session;
  const H5Handle opened = Open(dataset);
  const H5Handle space(H5Dget_space(opened.id()), H5Sclose);
  const int actual = H5Sget_simple_extent_ndims(space.id());
  if (actual != rank) {
    throw Error(Place(dataset) + " has rank " + std::to_string(actual) + ", expected " +
                std::to_string(rank));
  }
  std::vector<hsize_t> extents(rank);
  H5Sget_simple_extent_dims(space.id(), extents.data(), nullptr);
  std::vector<int64_t> shape;
  for (const hsize_t extent : extents) {
    if (extent > static_cast<hsize_t>(largest)) {
      throw Error(Place(dataset) + " has an extent of " + std::to_string(extent) +
                  ", expected at most " + std::to_string(largest));
    }
    shape.push_back(static_cast<int64_t>(extent));
  }
  return shape;
}

std::vector<float> H5InputFile::ReadFloats(const std::string& dataset) const {
  const H5Session session;
  const H5Handle opened = Open(dataset);
  const H5Handle type(H5Dget_type(opened.id()), H5Tclose);
  const H5T_class_t kind = H5Tget_class(type.id());
  if (kind != H5T_FLOAT && kind != H5T_INTEGER) {
    throw Error(Place(dataset) + " holds no numbers");
  }
  const H5Handle space(H5Dget_space(opened.id()), H5Sclose);
  std::vector<float> values(static_cast<std::size_t>(std::max<int64_t>(0, CountOf(space))));
  if (!values.empty() &&
      H5Dread(opened.id(), H5T_NATIVE_FLOAT, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()) < 0) {
    throw Error(Place(dataset) + " cannot be read" + H5Reason());
  }
  const auto bad = std::find_if_not(values.begin(), values.end(),
                                    [](float value) { return std::isfinite(value); });
  if (bad != values.end()) {
    throw Error(Place(dataset) + " has a value that is not finite at position " +
                std::to_string(bad - values.begin()));
  }
  return values;
}

std::vector<int> H5InputFile::ReadIntegers(const std::string& dataset) const {
  const H5Session session;
  const H5Handle opened = Open(dataset);
  const H5Handle type(H5Dget_type(opened.id()), H5Tclose);
  if (H5Tget_class(type.id()) != H5T_INTEGER) {
    throw Error(Place(dataset) + " holds no whole numbers");
  }
  const H5Handle space(H5Dget_space(opened.id()), H5Sclose);
  std::vector<int64_t> wide(static_cast<std::size_t>(std::max<int64_t>(0, CountOf(space))));
  if (!wide.empty() &&
      H5Dread(opened.id(), H5T_NATIVE_INT64, H5S_ALL, H5S_ALL, H5P_DEFAULT, wide.data()) < 0) {
    throw Error(Place(dataset) + " cannot be read" + H5Reason());
  }
  std::vector<int> values;
  values.reserve(wide.size());
  for (const int64_t value : wide) {
    if (value < std::numeric_limits<int>::min() || value > std::numeric_limits<int>::max()) {
      throw Error(Place(dataset) + " holds " + std::to_string(value) +
                  ", expected a number of 32 bits");
    }
    values.push_back(static_cast<int>(value));
  }
  return values;
}

bool H5InputFile::HasGroup(const std::string& group) const {
  const H5Session session;
  // H5Lexists fails where a part above is missing: ask part by part.
  for (std::size_t end = group.find('/', 1);; end = group.find('/', end + 1)) {
    const std::string part = group.substr(0, end);
    if (part.empty() || H5Lexists(file_.id(), part.c_str(), H5P_DEFAULT) <= 0) return false;
    const H5Handle opened(H5Gopen2(file_.id(), part.c_str(), H5P_DEFAULT), H5Gclose);
    if (!opened.valid()) return false;
    if (end == std::string::npos) return true;
  }
}

}  // namespace gluevo::vo::internal
