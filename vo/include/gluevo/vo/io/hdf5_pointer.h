#pragma once

#include <memory>

namespace gluevo::vo::internal {

class H5OutputFile;
class H5InputFile;

/// Deletes what only hdf5_file.h knows, so that headers that own such a file do without HDF5's.
struct H5Delete {
  void operator()(H5OutputFile* file) const;
  void operator()(H5InputFile* file) const;
};
using H5OutputPointer = std::unique_ptr<H5OutputFile, H5Delete>;
using H5InputPointer = std::unique_ptr<H5InputFile, H5Delete>;

}  // namespace gluevo::vo::internal
