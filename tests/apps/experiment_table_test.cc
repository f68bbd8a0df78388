// The columns of an experiment's tables.

#include "experiments/experiment_table.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace gluevo::apps {
namespace {

RunOutcome Outcome(const std::string& method, const nlohmann::ordered_json& metrics) {
  RunOutcome outcome;
  outcome.run.data = "hall";
  outcome.run.method = method;
  outcome.status = RunOutcome::Status::kDone;
  outcome.metrics = metrics;
  return outcome;
}

std::ptrdiff_t ColumnOf(const ExperimentTable& table, const std::string& title) {
  const auto found = std::find(table.header.begin(), table.header.end(), title);
  return found == table.header.end() ? -1 : found - table.header.begin();
}

TEST(ExperimentTable, LoopsHaveColumnsWhereARunLookedForThem) {
  const RunOutcome without = Outcome("klt", {{"ate_se3_m", 0.02}, {"resets", 0}});
  RunOutcome with = Outcome("superglue", without.metrics);
  with.metrics["loops_closed"] = 7;
  with.metrics["segments_joined"] = 2;
  with.metrics["linked_frames"] = 90;
  with.metrics["optimized"]["ate_se3_m"] = 0.0051;
  EXPECT_EQ(ColumnOf(MakeTable({without}), "loops"), -1);

  const ExperimentTable table = MakeTable({without, with});
  for (const auto& [title, value] : {std::pair{"loops", "7"},
                                     {"segments joined", "2"},
                                     {"frames linked", "90"},
                                     {"ATE SE(3) with loops, m", "0.0051"}}) {
    const std::ptrdiff_t column = ColumnOf(table, title);
    ASSERT_GE(column, 0) << title;
    EXPECT_EQ(table.rows[0][column], "-") << title;
    EXPECT_EQ(table.rows[1][column], value) << title;
  }
  ASSERT_EQ(table.rows[1].size(), table.header.size());
  EXPECT_EQ(ColumnOf(table, "ATE within segments, m"), -1);
  // For programs there are always the same columns.
  const std::string csv = OutcomesAsCsv({without});
  EXPECT_NE(csv.find("optimized_ate_se3_m,linked_frames,segments_joined,loops_closed"),
            std::string::npos)
      << csv;
}

TEST(ExperimentTable, AnInertialUnitHasColumnsWhereARunUsedIt) {
  const RunOutcome without = Outcome("klt, imu x", {{"ate_se3_m", 0.02}, {"resets", 0}});
  RunOutcome with = Outcome("klt, imu o", without.metrics);
  with.metrics["imu"] = {{"initialised_at_s", 3.0},
                         {"gravity_sigma_deg", 0.0123},
                         {"residual", {{"gyroscope", 0.141}, {"accelerometer", 0.306}}},
                         {"noise_factor", {{"gyroscope", 1.0}, {"accelerometer", 9.0}}}};
  RunOutcome waiting = Outcome("superglue, imu o", without.metrics);
  waiting.metrics["imu"] = {{"initialised_at_s", nullptr},
                            {"noise_factor", {{"gyroscope", 1.0}, {"accelerometer", 1.0}}}};
  EXPECT_EQ(ColumnOf(MakeTable({without}), "IMU starts, s"), -1);

  const ExperimentTable table = MakeTable({without, with, waiting});
  for (const auto& [title, value] : {std::pair{"IMU starts, s", "3.0"},
                                     {"gravity sigma, deg", "0.012"},
                                     {"IMU residual, rotation", "0.14"},
                                     {"IMU residual, velocity", "0.31"}}) {
    const std::ptrdiff_t column = ColumnOf(table, title);
    ASSERT_GE(column, 0) << title;
    EXPECT_EQ(table.rows[0][column], "-") << title;
    EXPECT_EQ(table.rows[1][column], value) << title;
    EXPECT_EQ(table.rows[2][column], "-") << title;
  }
  // For programs there are always the same columns.
  const std::string csv = OutcomesAsCsv({without});
  EXPECT_NE(csv.find("imu_initialised_at_s,imu_gravity_sigma_deg,imu_residual_gyroscope,imu_"
                     "residual_accelerometer"),
            std::string::npos)
      << csv;
  EXPECT_NE(csv.find("imu_accelerometer_noise_factor"), std::string::npos) << csv;
}

}  // namespace
}  // namespace gluevo::apps
