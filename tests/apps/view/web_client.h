#pragma once

#include <boost/asio/connect.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket.hpp>
#include <chrono>
#include <optional>
#include <string>

namespace gluevo::apps {

/// A WebSocket to a server on this machine.
class WebClient {
 public:
  /// Throws where the server refuses.
  WebClient(const std::string& port, const std::string& target, const std::string& origin = "")
      : stream_(context_) {
    boost::beast::get_lowest_layer(stream_).connect(
        boost::asio::ip::tcp::resolver(context_).resolve("127.0.0.1", port));
    stream_.set_option(boost::beast::websocket::stream_base::decorator(
        [origin](boost::beast::websocket::request_type& request) {
          if (!origin.empty()) {
            request.set(boost::beast::http::field::origin, origin);
          }
        }));
    stream_.read_message_max(0);
    stream_.handshake("127.0.0.1:" + port, target);
  }

  void Send(const std::string& text) { stream_.write(boost::asio::buffer(text)); }

  /// The next message; nothing where none comes within the time.
  std::optional<std::string> Receive(std::chrono::milliseconds within) {
    using boost::beast::error_code;
    if (!is_reading_) {
      is_reading_ = true;
      stream_.async_read(buffer_, [this](error_code error, std::size_t) { done_ = error; });
    }
    context_.restart();
    const auto end = std::chrono::steady_clock::now() + within;
    while (!done_ && std::chrono::steady_clock::now() < end) {
      context_.run_one_until(end);
    }
    if (!done_ || *done_) {
      return std::nullopt;
    }
    done_.reset();
    is_reading_ = false;
    std::string message = boost::beast::buffers_to_string(buffer_.data());
    buffer_.consume(buffer_.size());
    return message;
  }

 private:
  boost::asio::io_context context_;
  boost::beast::websocket::stream<boost::beast::tcp_stream> stream_;
  boost::beast::flat_buffer buffer_;
  bool is_reading_ = false;
  std::optional<boost::beast::error_code> done_;
};

struct WebAnswer {
  unsigned status = 0;
  std::string body;
  std::string policy;  ///< Content-Security-Policy.
};

/// What a server on this machine answers to a GET.
inline WebAnswer Get(const std::string& port, const std::string& target, const std::string& host) {
  namespace http = boost::beast::http;
  boost::asio::io_context context;
  boost::beast::tcp_stream stream(context);
  stream.connect(boost::asio::ip::tcp::resolver(context).resolve("127.0.0.1", port));
  http::request<http::empty_body> request(http::verb::get, target, 11);
  request.set(http::field::host, host);
  http::write(stream, request);
  boost::beast::flat_buffer buffer;
  http::response<http::string_body> response;
  http::read(stream, buffer, response);
  const auto policy = response["Content-Security-Policy"];
  return {response.result_int(), response.body(), {policy.data(), policy.size()}};
}

}  // namespace gluevo::apps
