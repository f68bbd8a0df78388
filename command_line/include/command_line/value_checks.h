#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

namespace gluevo::apps {

/// Checks of an option's value, whose message says what is expected and what was given. Numbers are
/// decimal and finite, those with bounds of type int whole. Such a check replaces CLI11's.
CLI::Validator AtLeast(int low);
CLI::Validator AtLeast(double low);
CLI::Validator Above(double low);
CLI::Validator Within(int low, int high);
CLI::Validator Within(double low, double high);
/// Of a whole, or a confidence: 0 or more, but below 1.
CLI::Validator Share();
CLI::Validator OneOf(const std::vector<std::string>& names);

/// Gives every option of a command, and of those below it, that has no check of its own one:
/// numbers are finite, whole where they are counted, switches true or false, names and texts not
/// empty.
void CheckAllValues(CLI::App& app);

}  // namespace gluevo::apps
