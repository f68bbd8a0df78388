#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "gluevo/vo/core/seconds.h"
#include "gluevo/vo/estimator/sliding_window.h"
#include "sliding_window_workspace.h"
#include "window_inertial.h"

// The inertial unit's part: velocities, biases and gravity beside the poses.
namespace gluevo::vo {
namespace {

using inertial_block::kAccelerometerBias;
using inertial_block::kGyroscopeBias;
using inertial_block::kPosition;
using inertial_block::kRotation;
using inertial_block::kVelocity;

// `start`'s information of biases and gravity as the prior of a window whose oldest frame is the
// linearisation's first. It is at its own linearisation point, so that it has no residual.
PosePrior WithStart(const std::optional<PosePrior>& prior, const PosePrior& linearization,
                    const InertialStart& start, double weight) {
  constexpr double kTwice = 2.0;  // In standard deviations.
  constexpr int kVelocitySize = 3;
  constexpr int kBiases = 6;
  Marginalizer marginalizer(linearization);
  if (prior) {
    marginalizer.AddPrior(*prior);
  }
  const Eigen::Matrix<double, 8, 8> information =
      weight * weight * (kTwice * kTwice * start.covariance).inverse();
  Eigen::MatrixXd hessian = Eigen::MatrixXd::Zero(linearization.Columns(), linearization.Columns());
  const Eigen::Index biases = linearization.MotionColumn(0) + kVelocitySize;
  const Eigen::Index gravity = linearization.GravityColumn();
  hessian.block<kBiases, kBiases>(biases, biases) = information.topLeftCorner<kBiases, kBiases>();
  hessian.block<2, kBiases>(gravity, biases) = information.bottomLeftCorner<2, kBiases>();
  hessian.block<2, 2>(gravity, gravity) = information.bottomRightCorner<2, 2>();
  if (linearization.time_offset_s) {
    const double sigma = kTwice * start.time_offset_sigma_s;
    const Eigen::Index offset = linearization.TimeOffsetColumn();
    hessian(offset, offset) = weight * weight / (sigma * sigma);
  }
  const Eigen::VectorXd zero = Eigen::VectorXd::Zero(linearization.Columns());
  marginalizer.Add(hessian, zero, zero);
  return marginalizer.Keep();
}

}  // namespace

void SlidingWindow::StartInertia(const InertialStart& start, const ImuReadings& readings) {
  readings_ = &readings;
  gravity_ = {start.gravity_in_world, Eigen::Vector2d::Zero()};
  if (start.time_offset_sigma_s > 0.0) {
    time_offset_s_ = readings.time_offset_s();
  }
  for (std::size_t i = 0; i < frames_.size(); ++i) {
    Frame& frame = frames_[i];
    frame.motion.bias = start.bias;
    if (i > 0) {
      frame.measured =
          FactorOf(readings.Between(frames_[i - 1].timestamp_ns, frame.timestamp_ns, start.bias));
    }
    // A guess; what is measured tells.
    const Frame& before = frames_[i > 0 ? i - 1 : 0];
    // Views alone do not tell rest from constant velocity.
    if (frame.still && start.rest_begin_ns && before.timestamp_ns >= *start.rest_begin_ns) {
      frame.still->weight = views_noise_.Factor();
    } else {
      frame.still.reset();
    }
    const Frame& after = frames_[i > 0 ? i : std::min<std::size_t>(1, frames_.size() - 1)];
    const auto duration_s = SecondsBetween(before.timestamp_ns, after.timestamp_ns);
    if (duration_s > 0.0) {
      frame.motion.velocity_in_world =
          (after.world_from_body.translation - before.world_from_body.translation) / duration_s;
    }
  }
  PosePrior linearization;
  if (prior_) {
    linearization = *prior_;
  } else {
    linearization.frame_ids = {frames_.front().id};
    linearization.world_from_body = {frames_.front().world_from_body};
    linearization.turn = calibration_.correction.turn;
  }
  linearization.motions = {frames_.front().motion};
  linearization.gravity_turn = gravity_.turn;
  linearization.time_offset_s = time_offset_s_;
  prior_ = WithStart(prior_, linearization, start, views_noise_.Factor());
}

std::unique_ptr<InertialFactor> SlidingWindow::FactorOf(const Preintegration& measured) const {
  return std::make_unique<InertialFactor>(MakeInertialFactor(measured, views_noise_.Factor()));
}

void SlidingWindow::StopInertia() {
  if (!has_inertia()) {
    return;
  }
  Marginalizer marginalizer(*prior_);
  marginalizer.AddPrior(*prior_);
  prior_ = marginalizer.EliminateInertia();
  readings_ = nullptr;
  time_offset_s_.reset();
  inertial_covariance_.reset();
  for (Frame& frame : frames_) {
    frame.motion = {};
    frame.measured.reset();
  }
}

void SlidingWindow::HoldStill(const StillFactor& still) {
  if (frames_.size() > 1) {
    frames_.back().still = still;
    frames_.back().still->weight = views_noise_.Factor();
  }
}

InertialState SlidingWindow::state() const { return StateOfFrame(frames_.back()); }

void SlidingWindow::Measure(const Frame& first, Frame& second) const {
  second.measured =
      FactorOf(readings_->Between(first.timestamp_ns, second.timestamp_ns, first.motion.bias));
  second.motion.bias = first.motion.bias;
  if (readings_->Cover(first.timestamp_ns, second.timestamp_ns)) {
    second.motion.velocity_in_world =
        vo::Predict(StateOfFrame(first), second.measured->measured, gravity_in_world())
            .velocity_in_world;
  } else {
    second.motion.velocity_in_world =
        (second.world_from_body.translation - first.world_from_body.translation) /
        second.measured->measured.duration_s;
  }
}

bool SlidingWindow::IsTimeOffsetFar(const Preintegration& measured) const {
  constexpr double kFar = 0.5e-3;
  return time_offset_s_ && std::abs(measured.time_offset_s - *time_offset_s_) > kFar &&
         std::abs(measured.time_offset_s - readings_->time_offset_s()) > 0.5 * kFar;
}

void SlidingWindow::JoinAcross(std::size_t index) {
  Frame& after = frames_[index + 1];
  const std::optional<StillFactor>& before = frames_[index].still;
  after.still = before && after.still ? std::optional(Join(*before, *after.still)) : std::nullopt;
  if (has_inertia()) {
    after.measured = FactorOf(Join(frames_[index].measured->measured, after.measured->measured));
  }
}

void SlidingWindow::AddInertiaToProblem() {
  if (!has_inertia()) {
    return;
  }
  WindowProblem& problem = workspace_->problem;
  problem.gravity = gravity_;
  problem.time_offset_s = time_offset_s_;
  for (std::size_t i = 0; i < frames_.size(); ++i) {
    Frame& frame = frames_[i];
    problem.motions.push_back(frame.motion);
    if (i == 0) {
      continue;
    }
    const Frame& before = frames_[i - 1];
    if (IsBiasFar(frame.measured->measured, before.motion.bias) ||
        IsTimeOffsetFar(frame.measured->measured)) {
      frame.measured =
          FactorOf(readings_->Between(before.timestamp_ns, frame.timestamp_ns, before.motion.bias));
    }
    problem.measured.push_back(frame.measured.get());
    if (frame.still) {
      problem.still.push_back({static_cast<int>(i) - 1, *frame.still});
    }
  }
}

void SlidingWindow::AddInertiaTo(Marginalizer& marginalizer) const {
  AddMeasured(*frames_[1].measured, {StateOfFrame(frames_[0]), StateOfFrame(frames_[1])}, gravity_,
              time_offset_s_, Delta(marginalizer.linearization()), marginalizer);
  if (frames_[1].still) {
    AddStill(*frames_[1].still, {StateOfFrame(frames_[0]), StateOfFrame(frames_[1])},
             Delta(marginalizer.linearization()), marginalizer);
  }
}

SlidingWindow::InertialMisfit SlidingWindow::Misfit() const {
  if (!has_inertia() || frames_.size() < 2) {
    return {};
  }
  const Frame& before = frames_[frames_.size() - 2];
  const InertialVector residual =
      Whitened(*frames_.back().measured, StateOfFrame(before), StateOfFrame(frames_.back()),
               gravity_in_world(), time_offset_s_)
          .value /
      frames_.back().measured->weight;
  const auto squares = [&](int block) { return residual.segment<3>(block).squaredNorm(); };
  return {(squares(kRotation) + squares(kGyroscopeBias)) / 6.0,
          (squares(kPosition) + squares(kVelocity) + squares(kAccelerometerBias)) / 9.0};
}

std::optional<SlidingWindow::Prediction> SlidingWindow::Predict(int64_t timestamp_ns) const {
  if (!has_inertia() || frames_.empty() || !inertial_covariance_) {
    return std::nullopt;
  }
  const Frame& newest = frames_.back();
  if (timestamp_ns <= newest.timestamp_ns || !readings_->Cover(newest.timestamp_ns, timestamp_ns)) {
    return std::nullopt;
  }
  const Preintegration measured =
      readings_->Between(newest.timestamp_ns, timestamp_ns, newest.motion.bias);
  const Eigen::Matrix3d world_from_body = newest.world_from_body.rotation.toRotationMatrix();
  const double dt = measured.duration_s;
  // Position (world) and rotation (body) by velocity, biases and gravity's turn.
  Eigen::Matrix<double, 6, 11> by_motion = Eigen::Matrix<double, 6, 11>::Zero();
  by_motion.topLeftCorner<3, 3>() = dt * Eigen::Matrix3d::Identity();
  by_motion.block<3, 6>(0, 3) = world_from_body * measured.by_bias.middleRows<3>(kPosition);
  by_motion.block<3, 6>(3, 3) = measured.by_bias.middleRows<3>(kRotation);
  by_motion.topRightCorner<3, 2>() = 0.5 * dt * dt * gravity_.ByTurn();
  Prediction prediction{vo::Predict(StateOfFrame(newest), measured, gravity_in_world()), {}};
  Eigen::Matrix<double, 6, 6> own = Eigen::Matrix<double, 6, 6>::Identity();
  own.topLeftCorner<3, 3>() = world_from_body;
  Eigen::Matrix<double, 6, 6> to_body = Eigen::Matrix<double, 6, 6>::Identity();
  to_body.topLeftCorner<3, 3>() =
      prediction.state.world_from_body.rotation.toRotationMatrix().transpose();
  const Eigen::Matrix<double, 6, 6> sum =
      by_motion * *inertial_covariance_ * by_motion.transpose() +
      own * measured.covariance.topLeftCorner<6, 6>() * own.transpose();
  prediction.covariance = to_body * sum * to_body.transpose();
  return prediction;
}

}  // namespace gluevo::vo
