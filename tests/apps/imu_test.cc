// gluevo run --imu as a user runs it.

#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <nlohmann/json.hpp>

#include "apps/command_test.h"

namespace gluevo::apps {
namespace {

class ImuTest : public CommandTest {
 protected:
  nlohmann::json Metrics(const std::string& run) const {
    std::ifstream file(fs::path(Path(run)) / "metrics.json");
    return nlohmann::json::parse(file);
  }
  // Without comments.
  long Poses(const std::string& file) const {
    const std::string text = Contents(file);
    return std::count(text.begin(), text.end(), '\n') - std::count(text.begin(), text.end(), '#');
  }
};

TEST_F(ImuTest, IsUsedWhereTheDataSetHasOne) {
  const std::string flight = Path("flight");
  const Outcome made =
      Run("simulate -o " + flight + " --path figure_eight --duration 12 --width 320 --height 240");
  ASSERT_EQ(made.exit_code, 0) << made.error;
  const std::string run = "run " + flight + " --method klt -o ";

  const Outcome with = Run(run + Path("with") + " --imu-rate");
  ASSERT_EQ(with.exit_code, 0) << with.error;
  const nlohmann::json imu = Metrics("with").at("imu");
  ASSERT_TRUE(imu.at("initialised_at_s").is_number()) << imu;
  EXPECT_LT(imu.at("initialised_at_s"), 10.0);
  EXPECT_LT(imu.at("gravity_sigma_deg"), 0.5);
  const fs::path folder = Path("with");
  EXPECT_NE(Contents(folder / "trajectory.tum").find("z is up"), std::string::npos);
  // 200 readings a second, and 10 frames.
  EXPECT_GT(Poses(folder / "imu_rate.tum"),
            15 * (120 - 10.0 * imu.at("initialised_at_s").get<double>()));
  EXPECT_EQ(Poses(folder / "trajectory.tum"), 120);

  const Outcome without = Run(run + Path("without") + " --imu off");
  ASSERT_EQ(without.exit_code, 0) << without.error;
  EXPECT_FALSE(Metrics("without").contains("imu"));
  EXPECT_EQ(Contents(fs::path(Path("without")) / "trajectory.tum").find("z is up"),
            std::string::npos);
  EXPECT_LT(Metrics("with").at("ate_se3_m"),
            1.5 * Metrics("without").at("ate_se3_m").get<double>());

  const Outcome rate = Run(run + Path("rate") + " --imu off --imu-rate");
  EXPECT_NE(rate.exit_code, 0);
  EXPECT_NE(rate.error.find("--imu-rate"), std::string::npos) << rate.error;
  EXPECT_FALSE(fs::exists(fs::path(Path("rate")) / "trajectory.tum"));

  const Outcome offset = Run(run + Path("offset") + " --estimate-time-offset");
  ASSERT_EQ(offset.exit_code, 0) << offset.error;
  const nlohmann::json estimated = Metrics("offset").at("imu");
  // These images are coarse: as near as it says.
  const double sigma_s = estimated.at("time_offset_sigma_s");
  EXPECT_NEAR(estimated.at("time_offset_s").get<double>(), 0.0, 4.0 * sigma_s);
  EXPECT_GT(sigma_s, 0.0);
  EXPECT_LT(sigma_s, 1e-3);
  EXPECT_FALSE(imu.contains("time_offset_s"));
  EXPECT_NE(Contents(fs::path(Path("offset")) / "report.html").find("Time offset"),
            std::string::npos);
  const Outcome no_unit = Run(run + Path("no_unit") + " --imu off --estimate-time-offset");
  EXPECT_NE(no_unit.exit_code, 0);
  EXPECT_NE(no_unit.error.find("--estimate-time-offset"), std::string::npos) << no_unit.error;

  const Outcome no_use = Run(run + Path("no_use") + " --imu off --imu-calibration " + flight +
                             "/mav0/imu0/sensor.yaml");
  EXPECT_EQ(no_use.exit_code, 2);
  EXPECT_NE(no_use.error.find("--imu off"), std::string::npos) << no_use.error;
  EXPECT_NE(no_use.error.find("--imu-calibration"), std::string::npos) << no_use.error;

  // Too short for a start.
  const Outcome short_run = Run(run + Path("short") + " --count 4");
  ASSERT_EQ(short_run.exit_code, 0) << short_run.error;
  EXPECT_NE(short_run.out.find("The inertial unit has not started: "), std::string::npos)
      << short_run.out;

  fs::remove(fs::path(flight) / "mav0" / "imu0" / "data.csv");
  const Outcome empty = Run(run + Path("empty") + " --count 4");
  ASSERT_EQ(empty.exit_code, 0) << empty.error;
  EXPECT_NE(empty.error.find("the inertial unit is not used: "), std::string::npos) << empty.error;
  EXPECT_NE(empty.error.find("data.csv: no such file"), std::string::npos) << empty.error;

  fs::remove_all(fs::path(flight) / "mav0" / "imu0");
  const Outcome none = Run(run + Path("none") + " --imu on");
  EXPECT_NE(none.exit_code, 0);
  EXPECT_NE(none.error.find("has no inertial unit"), std::string::npos) << none.error;
}

}  // namespace
}  // namespace gluevo::apps
