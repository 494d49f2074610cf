#include "server/rpc/step/request_window.h"

#include <utility>

namespace procgen {

RequestWindow::RequestWindow() { Grow(1); }

void RequestWindow::Grow(size_t slot_count) {
  while (slots_.size() < slot_count) {
    slots_.push_back(std::make_unique<StreamRequest>());
    free_.push_back(slots_.back().get());
  }
}

bool RequestWindow::CanRead() const {
  return reading_ == nullptr && !parsing_ && !reading_ended_ && !free_.empty();
}

void RequestWindow::BeginRead() {
  reading_ = free_.back();
  free_.pop_back();
}

void RequestWindow::AbandonRead() {
  if (reading_ != nullptr) {
    free_.push_back(std::exchange(reading_, nullptr));
  }
}

StreamRequest* RequestWindow::EndRead(bool ok) {
  StreamRequest* request = std::exchange(reading_, nullptr);
  if (!ok || reading_ended_) {
    reading_ended_ = true;
    return nullptr;
  }
  parsing_ = true;
  return request;
}

void RequestWindow::Enqueue(StreamRequest* request) {
  parsing_ = false;
  if (!reading_ended_) {
    inbox_.push_back(request);
  }
}

StreamRequest* RequestWindow::Next() {
  if (inbox_.empty()) {
    return nullptr;
  }
  StreamRequest* request = inbox_.front();
  inbox_.pop_front();
  return request;
}

void RequestWindow::Stop() {
  reading_ended_ = true;
  inbox_.clear();
}

}  // namespace procgen
