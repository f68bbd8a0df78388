#pragma once

#include <functional>
#include <memory>
#include <string>

#include "view_address.h"
#include "view_state.h"

namespace gluevo::apps {

/// Serves the view's page and, by WebSocket, what it shows, on a thread of its own.
class ViewServer {
 public:
  /// `command`: what a page's button asks for ("pause", "resume", "save"), called on the server's
  /// thread. The state must outlive the server. Throws Error where the address cannot be had.
  ViewServer(const ViewAddress& address, const ViewState& state,
             std::function<void(const std::string&)> command);
  ~ViewServer();
  ViewServer(const ViewServer&) = delete;
  ViewServer& operator=(const ViewServer&) = delete;

  /// For a browser; with the token.
  std::string url() const;
  /// How many pages look.
  int viewers() const;
  /// The state has changed. Returns at once; any thread may call it.
  void Wake();

 private:
  class Server;
  std::unique_ptr<Server> server_;
};

}  // namespace gluevo::apps
