#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>

#include "gluevo/vo/estimator/pose_prior.h"
#include "gluevo/vo/inertial/gravity.h"
#include "gluevo/vo/inertial/inertial_factor.h"
#include "gluevo/vo/inertial/inertial_residual.h"
#include "gluevo/vo/inertial/still_factor.h"
#include "window_problem.h"
#include "window_system.h"

// What an inertial unit says of frames that follow each other (Forster et al., "On-Manifold
// Preintegration", T-RO 2017).
namespace gluevo::vo {

/// Velocity and biases plus, in the order of inertial errors.
VelocityAndBias Plus(const VelocityAndBias& motion,
                     const Eigen::Matrix<double, WindowColumns::kMotion, 1>& delta);

/// Half the sum of squares; 0 without a unit.
double InertialCost(const WindowProblem& problem, const WindowState& state);
/// Adds all factors to the normal equations of a system whose columns have inertia; nothing without
/// a unit.
void AddInertial(const WindowProblem& problem, const WindowState& state, WindowSystem& system);

/// Whitened with derivatives by gravity's turn (GravityEstimate) in place of those by
/// TurnedGravity().
WhitenedInertialResidual WhitenedByTurn(const InertialFactor& factor, const InertialState& first,
                                        const InertialState& second, const GravityEstimate& gravity,
                                        const std::optional<double>& time_offset_s);

/// Where a factor's columns stand: of pose and motion of the first frame, of the second, of
/// gravity. A negative one is fixed.
using InertialPlaces = std::array<int, 5>;
/// Adds both triangles of a factor's part: with its time offset, whose column is `time_offset`,
/// where that is not negative.
void AddAt(const WhitenedInertialResidual& residual, const InertialPlaces& places, int time_offset,
           Eigen::MatrixXd& hessian, Eigen::VectorXd& gradient);
/// Likewise without time offset.
void AddAt(const InertialNormalEquations& equations, const InertialPlaces& places,
           Eigen::MatrixXd& hessian, Eigen::VectorXd& gradient);

/// Adds what was measured between the first two frames of a marginalizer, which have motions: the
/// residual of the present states, gravity and time offset, `delta` away from the linearisation
/// point, with derivatives there (see PosePrior).
void AddMeasured(const InertialFactor& factor, const std::array<InertialState, 2>& present,
                 const GravityEstimate& present_gravity,
                 const std::optional<double>& present_time_offset_s, const Eigen::VectorXd& delta,
                 Marginalizer& marginalizer);

/// Likewise that the body stood still between them.
void AddStill(const StillFactor& factor, const std::array<InertialState, 2>& present,
              const Eigen::VectorXd& delta, Marginalizer& marginalizer);

}  // namespace gluevo::vo
