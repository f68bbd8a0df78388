#include <algorithm>
#include <cmath>
#include <limits>
#include <string_view>
#include <system_error>
#include <type_traits>

#include "gluevo/nn/error.h"
#include "gluevo/vo/io/hdf5_file.h"
#include "gluevo/vo/io/whole_file.h"

namespace gluevo::vo::internal {
namespace {

int64_t CountOf(const H5Handle& space) {
  return static_cast<int64_t>(H5Sget_simple_extent_npoints(space.id()));
}

}  // namespace

H5InputFile::H5InputFile(const std::filesystem::path& path) : path_(path) {
  const H5Session session;
  std::error_code code;
  if (std::filesystem::is_directory(path, code)) {
    throw Error(path.string() + ": a folder, expected an HDF5 file");
  }
  if (!std::filesystem::is_regular_file(path, code)) {
    throw Error(path.string() + ": " + WhyNoFile(path));
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

bool H5InputFile::Has(const std::string& name) const {
  const H5Session session;
  return H5Lexists(file_.id(), name.c_str(), H5P_DEFAULT) > 0;
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

template <typename Value>
std::vector<Value> H5InputFile::ReadAll(const H5Handle& opened, const std::string& dataset,
                                        hid_t memory_type) const {
  const H5Handle type(H5Dget_type(opened.id()), H5Tclose);
  const H5T_class_t kind = H5Tget_class(type.id());
  const bool whole = std::is_integral_v<Value>;
  if (kind != H5T_INTEGER && (whole || kind != H5T_FLOAT)) {
    throw Error(Place(dataset) + (whole ? " holds no whole numbers" : " holds no numbers"));
  }
  const H5Handle space(H5Dget_space(opened.id()), H5Sclose);
  std::vector<Value> values(static_cast<std::size_t>(std::max<int64_t>(0, CountOf(space))));
  if (!values.empty() &&
      H5Dread(opened.id(), memory_type, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()) < 0) {
    throw Error(Place(dataset) + " cannot be read" + H5Reason());
  }
  return values;
}

std::vector<float> H5InputFile::ReadFloats(const std::string& dataset) const {
  const H5Session session;
  std::vector<float> values = ReadAll<float>(Open(dataset), dataset, H5T_NATIVE_FLOAT);
  const auto bad = std::find_if_not(values.begin(), values.end(),
                                    [](float value) { return std::isfinite(value); });
  if (bad != values.end()) {
    throw Error(Place(dataset) + " has a value that is not finite at position " +
                std::to_string(bad - values.begin()));
  }
  return values;
}

std::vector<int> H5InputFile::ReadIntegers(const std::string& dataset) const {
  std::vector<int> values;
  for (const int64_t value : ReadLongIntegers(dataset)) {
    if (value < std::numeric_limits<int>::min() || value > std::numeric_limits<int>::max()) {
      throw Error(Place(dataset) + " holds " + std::to_string(value) +
                  ", expected a number of 32 bits");
    }
    values.push_back(static_cast<int>(value));
  }
  return values;
}

std::vector<double> H5InputFile::ReadDoubles(const std::string& dataset) const {
  const H5Session session;
  return ReadAll<double>(Open(dataset), dataset, H5T_NATIVE_DOUBLE);
}

std::vector<int64_t> H5InputFile::ReadLongIntegers(const std::string& dataset) const {
  const H5Session session;
  return ReadAll<int64_t>(Open(dataset), dataset, H5T_NATIVE_INT64);
}

std::map<std::string, std::string> H5InputFile::ReadTexts(const std::string& group) const {
  const H5Session session;
  const H5Handle opened(H5Gopen2(file_.id(), group.c_str(), H5P_DEFAULT), H5Gclose);
  if (!opened.valid()) throw Error(Place(group) + " is no readable group" + H5Reason());
  const H5Handle text_type(H5Tcopy(H5T_C_S1), H5Tclose);
  H5Tset_size(text_type.id(), H5T_VARIABLE);
  H5Tset_cset(text_type.id(), H5T_CSET_UTF8);

  std::vector<std::string> names;
  const H5A_operator2_t visit = [](hid_t, const char* name, const H5A_info_t*,
                                   void* data) -> herr_t {
    try {
      static_cast<std::vector<std::string>*>(data)->emplace_back(name);
      return 0;
    } catch (...) {
      return -1;
    }
  };
  if (H5Aiterate2(opened.id(), H5_INDEX_NAME, H5_ITER_INC, nullptr, visit, &names) < 0) {
    throw Error(Place(group) + " cannot be listed" + H5Reason());
  }
  std::map<std::string, std::string> texts;
  for (const std::string& name : names) {
    const H5Handle attribute(H5Aopen(opened.id(), name.c_str(), H5P_DEFAULT), H5Aclose);
    const H5Handle type(H5Aget_type(attribute.id()), H5Tclose);
    const H5Handle space(H5Aget_space(attribute.id()), H5Sclose);
    char* text = nullptr;
    if (H5Tis_variable_str(type.id()) > 0 && CountOf(space) == 1 &&
        H5Aread(attribute.id(), text_type.id(), static_cast<void*>(&text)) >= 0 &&
        text != nullptr) {
      texts[name] = text;
      H5free_memory(text);
    }
  }
  return texts;
}

H5InputPointer OpenH5(const std::filesystem::path& path) {
  return H5InputPointer(new H5InputFile(path));
}

void H5Delete::operator()(H5InputFile* file) const { delete file; }

}  // namespace gluevo::vo::internal
