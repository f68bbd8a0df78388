#pragma once

#include <gtest/gtest.h>

#include <functional>
#include <string>

#include "gluevo/nn/error.h"

namespace gluevo {

/// The message of the Error that is thrown, which must be one line; "no error" where there is none.
inline std::string MessageOf(const std::function<void()>& action) {
  try {
    action();
  } catch (const Error& error) {
    std::string message = error.what();
    EXPECT_EQ(message.find('\n'), std::string::npos) << message;
    return message;
  }
  return "no error";
}

}  // namespace gluevo
