#pragma once

#include <hdf5.h>

#include <cstdint>
#include <string>
#include <vector>

namespace gluevo::vo::internal {

/// An open file that HDF5 fills through a driver of ours, which never tells it that a write failed:
/// HDF5 cannot close a file after that, and crashes at the program's end. What cannot be written is
/// kept in memory so that HDF5 reads what it wrote, until whoever sees error() gives the file up.
class H5OutputStorage {
 public:
  /// The file stays open, and the caller's.
  explicit H5OutputStorage(int descriptor) : descriptor_(descriptor) {}

  /// errno of the first write that failed; 0 where there was none.
  int error() const { return error_; }

  void Write(std::uint64_t address, const void* bytes, std::size_t size);
  /// What was never written is zeros. False where the file cannot be read.
  bool Read(std::uint64_t address, void* bytes, std::size_t size) const;
  void Truncate(std::uint64_t size);
  std::uint64_t end() const { return end_; }

 private:
  struct Lost {
    std::uint64_t address;
    std::string bytes;
  };
  int descriptor_;
  int error_ = 0;
  std::uint64_t end_ = 0;  // Of what was written or lost.
  std::vector<Lost> lost_;
};

/// Access properties of a file that is `storage`, which must outlive it; to be closed by H5Pclose.
/// Within an H5Session.
hid_t MakeOutputAccess(H5OutputStorage* storage);

}  // namespace gluevo::vo::internal
