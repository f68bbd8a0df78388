#include <cstddef>
#include <cstdint>
#include <string_view>

#include "gluevo/nn/error.h"
#include "imu_faults.h"
#include "imu_table.h"
#include "imu_units.h"

// A table of an inertial unit's readings, and what is done about its faults.
extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, std::size_t size) {
  using namespace gluevo;
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  try {
    vo::ImuData imu;
    imu.samples = vo::ParseImuTable(text, "imu.csv").samples;
    vo::FitUnitOfForces(imu);
    vo::FitUnitOfRates(imu);
    vo::CleanImu(imu);
    vo::CheckCoverage({-1, 0, 1'403'715'273'262'142'976}, imu);
    // Those that are used are in order.
    for (std::size_t i = 1; i < imu.samples.size() && imu.refused.empty(); ++i) {
      if (imu.samples[i].timestamp_ns <= imu.samples[i - 1].timestamp_ns) {
        __builtin_trap();
      }
    }
  } catch (const Error&) {  // The one answer that a broken file may get.
  }
  return 0;
}
