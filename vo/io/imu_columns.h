#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

#include "column_names.h"

namespace gluevo::vo {

/// Where the readings of an inertial unit stand in the row of a table, from 0. The defaults are
/// EuRoC's order.
struct ImuColumns : TimeColumn {
  std::array<std::size_t, 3> rates = {1, 2, 3};   ///< x y z of the gyroscope.
  std::array<std::size_t, 3> forces = {4, 5, 6};  ///< x y z of the accelerometer.
  std::optional<double> radians;                  ///< Of one unit of the rates, where it is said.
  std::optional<double> metres;  ///< m/s^2 of one unit of the forces, where it is said.

  /// Columns that a row must have.
  std::size_t Count() const;
};

/// Standard gravity, m/s^2: what a sensor's data sheet calls g.
inline constexpr double kStandardGravity = 9.80665;

/// What the first line of a table says of its columns.
struct ImuHeader {
  std::optional<ImuColumns> columns;  ///< Where time and both sensors are named.
  /// What is not named where others are, for a message: "accelerations (ax, ay, az)"; empty where
  /// nothing of an inertial unit is named.
  std::string missing;
};

/// Takes the names of many tools: "w_RS_S_x [rad s^-1]", "wx", "gyro_x", "angular_velocity.x",
/// "omega_x"; "a_RS_S_x", "ax", "acc_x", "linear_acceleration.x"; a time as in other tables, of
/// several that of the message's header.
ImuHeader ImuHeaderOf(std::string_view header);

}  // namespace gluevo::vo
