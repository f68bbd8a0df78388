#include "gluevo/vo/io/hdf5_file.h"

#include <algorithm>
#include <system_error>
#include <utility>

#include "gluevo/nn/error.h"
#include "gluevo/nn/output_file.h"
#include "hdf5_output_driver.h"

namespace gluevo::vo::internal {
namespace {

/// HDF5 walks through what it calls an error stack; the innermost entry tells the cause.
herr_t KeepFirst(unsigned position, const H5E_error2_t* error, void* text) {
  if (position == 0 && error->desc != nullptr) *static_cast<std::string*>(text) = error->desc;
  return 0;
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

H5OutputFile::H5OutputFile(const std::filesystem::path& path)
    : path_(path),
      unfinished_(std::make_unique<nn::UnfinishedFile>(path)),
      storage_(std::make_unique<H5OutputStorage>(unfinished_->descriptor())) {
  const H5Session session;
  const H5Handle access(MakeOutputAccess(storage_.get()), H5Pclose);
  file_ = H5Handle(
      H5Fcreate(unfinished_->beside().c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, access.id()), H5Fclose);
  if (!file_.valid()) throw Error(path_.string() + ": cannot be written" + H5Reason());
}

H5OutputFile::~H5OutputFile() {
  const H5Session session;
  file_.Close();
}

std::string H5OutputFile::Reason() const {
  if (storage_->error() == 0) return H5Reason();
  return ": " + std::generic_category().message(storage_->error());
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
  if (!made.valid() || storage_->error() != 0) {
    throw Error(place + " cannot be written" + Reason());
  }
}

void H5OutputFile::Write(const std::string& dataset, const std::vector<hsize_t>& shape,
                         const float* values) {
  Write(dataset, shape, H5T_IEEE_F32LE, H5T_NATIVE_FLOAT, values);
}

void H5OutputFile::Write(const std::string& dataset, const std::vector<hsize_t>& shape,
                         const double* values) {
  Write(dataset, shape, H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE, values);
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
      !made.Close() || storage_->error() != 0) {
    throw Error(path_.string() + ": dataset " + Quoted(dataset) + " cannot be written" + Reason());
  }
}

void H5OutputFile::WriteTexts(const std::string& group,
                              const std::map<std::string, std::string>& texts) {
  const H5Session session;
  CheckOpen();
  const H5Handle type(H5Tcopy(H5T_C_S1), H5Tclose);
  H5Tset_size(type.id(), H5T_VARIABLE);
  H5Tset_cset(type.id(), H5T_CSET_UTF8);
  const H5Handle space(H5Screate(H5S_SCALAR), H5Sclose);
  for (const auto& [name, text] : texts) {
    const char* const value = text.c_str();
    const H5Handle made(H5Acreate_by_name(file_.id(), group.c_str(), name.c_str(), type.id(),
                                          space.id(), H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT),
                        H5Aclose);
    if (!made.valid() || H5Awrite(made.id(), type.id(), static_cast<const void*>(&value)) < 0 ||
        storage_->error() != 0) {
      throw Error(path_.string() + ": attribute " + Quoted(name) + " of group " + Quoted(group) +
                  " cannot be written" + Reason());
    }
  }
}

void H5OutputFile::Finish() {
  const H5Session session;
  CheckOpen();
  const bool is_closed = H5Fflush(file_.id(), H5F_SCOPE_GLOBAL) >= 0 && file_.Close();
  if (!is_closed || storage_->error() != 0) {
    throw Error(path_.string() + ": cannot be written" + Reason());
  }
  unfinished_->Finish();
}

H5OutputPointer CreateH5(const std::filesystem::path& path) {
  return H5OutputPointer(new H5OutputFile(path));
}

void H5Delete::operator()(H5OutputFile* file) const { delete file; }

}  // namespace gluevo::vo::internal
