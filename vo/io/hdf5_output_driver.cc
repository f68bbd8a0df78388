#include "hdf5_output_driver.h"

#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <limits>

#if H5_VERSION_GE(1, 13, 0)
#include <H5FDdevelop.h>
#endif

namespace gluevo::vo::internal {
namespace {

constexpr haddr_t kLargest = std::numeric_limits<off_t>::max();

// What HDF5 carries from the access properties to Open().
struct Properties {
  H5OutputStorage* storage;
};

// H5FD_t comes first: HDF5 takes the one for the other.
struct Driver {
  H5FD_t base;
  H5OutputStorage* storage;
  haddr_t end_of_addresses;
};

Driver* ToDriver(H5FD_t* file) { return reinterpret_cast<Driver*>(file); }
const Driver* ToDriver(const H5FD_t* file) { return reinterpret_cast<const Driver*>(file); }

H5FD_t* Open(const char* /*name*/, unsigned /*flags*/, hid_t access, haddr_t /*largest*/) {
  const auto* const properties = static_cast<const Properties*>(H5Pget_driver_info(access));
  return properties == nullptr ? nullptr : &(new Driver{{}, properties->storage, 0})->base;
}

herr_t Close(H5FD_t* file) {
  delete ToDriver(file);
  return 0;
}

// What HDF5's own driver for files says, so that its files are the same bytes.
herr_t Query(const H5FD_t* /*file*/, unsigned long* flags) {
  *flags = H5FD_FEAT_AGGREGATE_METADATA | H5FD_FEAT_ACCUMULATE_METADATA | H5FD_FEAT_DATA_SIEVE |
           H5FD_FEAT_AGGREGATE_SMALLDATA | H5FD_FEAT_DEFAULT_VFD_COMPATIBLE;
  return 0;
}

haddr_t GetEndOfAddresses(const H5FD_t* file, H5FD_mem_t /*type*/) {
  return ToDriver(file)->end_of_addresses;
}

herr_t SetEndOfAddresses(H5FD_t* file, H5FD_mem_t /*type*/, haddr_t address) {
  ToDriver(file)->end_of_addresses = address;
  return 0;
}

haddr_t GetEndOfFile(const H5FD_t* file, H5FD_mem_t /*type*/) {
  return ToDriver(file)->storage->end();
}

herr_t Read(H5FD_t* file, H5FD_mem_t /*type*/, hid_t /*transfer*/, haddr_t address,
            std::size_t size, void* bytes) {
  return ToDriver(file)->storage->Read(address, bytes, size) ? 0 : -1;
}

herr_t Write(H5FD_t* file, H5FD_mem_t /*type*/, hid_t /*transfer*/, haddr_t address,
             std::size_t size, const void* bytes) {
  ToDriver(file)->storage->Write(address, bytes, size);
  return 0;
}

herr_t Truncate(H5FD_t* file, hid_t /*transfer*/, hbool_t /*is_closing*/) {
  ToDriver(file)->storage->Truncate(ToDriver(file)->end_of_addresses);
  return 0;
}

H5FD_class_t DriverClass() {
  H5FD_class_t driver = {};
#if H5_VERSION_GE(1, 13, 0)
  driver.version = H5FD_CLASS_VERSION;
  driver.value = static_cast<H5FD_class_value_t>(511);  // Of those free for anybody's drivers.
#endif
  driver.name = "gluevo_output";
  driver.maxaddr = kLargest;
  driver.fc_degree = H5F_CLOSE_WEAK;
  driver.fapl_size = sizeof(Properties);
  driver.open = Open;
  driver.close = Close;
  driver.query = Query;
  driver.get_eoa = GetEndOfAddresses;
  driver.set_eoa = SetEndOfAddresses;
  driver.get_eof = GetEndOfFile;
  driver.read = Read;
  driver.write = Write;
  driver.truncate = Truncate;
  constexpr H5FD_mem_t kFreeLists[H5FD_MEM_NTYPES] = H5FD_FLMAP_DICHOTOMY;
  std::copy(std::begin(kFreeLists), std::end(kFreeLists), std::begin(driver.fl_map));
  return driver;
}

}  // namespace

void H5OutputStorage::Write(std::uint64_t address, const void* bytes, std::size_t size) {
  const auto* const text = static_cast<const char*>(bytes);
  end_ = std::max(end_, address + size);
  std::size_t done = 0;
  while (done < size && error_ == 0) {
    const ssize_t written =
        ::pwrite(descriptor_, text + done, size - done, static_cast<off_t>(address + done));
    if (written >= 0) {
      done += static_cast<std::size_t>(written);
    } else if (errno != EINTR) {
      error_ = errno;
    }
  }
  if (done < size) {
    lost_.push_back({address + done, std::string(text + done, size - done)});
  }
}

bool H5OutputStorage::Read(std::uint64_t address, void* bytes, std::size_t size) const {
  auto* const text = static_cast<char*>(bytes);
  std::size_t done = 0;
  while (done < size) {
    const ssize_t read =
        ::pread(descriptor_, text + done, size - done, static_cast<off_t>(address + done));
    if (read > 0) {
      done += static_cast<std::size_t>(read);
    } else if (read == 0) {
      std::memset(text + done, 0, size - done);
      done = size;
    } else if (errno != EINTR) {
      return false;
    }
  }
  for (const Lost& lost : lost_) {
    const std::uint64_t begin = std::max(address, lost.address);
    const std::uint64_t end = std::min(address + size, lost.address + lost.bytes.size());
    if (begin < end) {
      std::memcpy(text + (begin - address), lost.bytes.data() + (begin - lost.address),
                  end - begin);
    }
  }
  return true;
}

void H5OutputStorage::Truncate(std::uint64_t size) {
  end_ = size;
  if (error_ == 0 && ::ftruncate(descriptor_, static_cast<off_t>(size)) != 0) {
    error_ = errno;
  }
}

hid_t MakeOutputAccess(H5OutputStorage* storage) {
  // HDF5 1.10 copies the class, 1.14 does not.
  static const H5FD_class_t driver_class = DriverClass();
  static const hid_t driver = H5FDregister(&driver_class);
  const hid_t access = H5Pcreate(H5P_FILE_ACCESS);
  const Properties properties = {storage};
  H5Pset_driver(access, driver, &properties);
  return access;
}

}  // namespace gluevo::vo::internal
