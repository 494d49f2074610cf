#include "envcore/games/game.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <utility>

#include "envcore/games/game_variants.h"
#include "envcore/world/contacts.h"
#include "envcore/world/motion.h"

namespace procgen {
namespace {

constexpr int32_t kMoveCount = 9;  // actions below this are moves
constexpr int32_t kSharedRandomRange = 1000000;
constexpr float kAgentRadius = 0.4F;  // cells; some games change it
constexpr double kVelocityDecay = 0.9;
constexpr float kSpinDecay = 0.5F;
constexpr float kSpinPerTurn = 0.130899698F;  // radians per step

}  // namespace

Game::Game(const GameArtSpec& art, const GameOptions& options)
    : center_agent_(options.center_agent), art_(art), options_(options) {}

void Game::StartLevel(int32_t level_seed) {
  random_.Seed(level_seed);
  MakeLevel();
  ApplyVariant(options_.variant, level_seed, &world_);
  step_number_ = 0;
}

void Game::Play(int32_t action) {
  ++step_number_;
  outcome_ = StepOutcome();
  move_ = action < kMoveCount ? action : kNoAction;
  special_action_ = action < kMoveCount ? 0 : action - (kMoveCount - 1);
  PlayStep();
}

void Game::StandardReset(int width, int height, AgentStart agent_start) {
  background_offset_ = random_.Unit();
  const auto group_size = static_cast<int32_t>(BackgroundsOf(art_.background_group).size());
  background_index_ = random_.Int(options_.use_generated_assets ? 1 : group_size);
  if (options_.use_generated_assets) {
    generated_background_ = GenerateBackground(random_);
  }
  float x = kAgentRadius;
  float y = kAgentRadius;
  if (agent_start == AgentStart::kRandom) {
    x = random_.Unit() * (static_cast<float>(width) - 2 * kAgentRadius) + kAgentRadius;
    y = random_.Unit() * (static_cast<float>(height) - 2 * kAgentRadius) + kAgentRadius;
  }
  world_.entities.clear();
  Entity& agent = world_.entities.emplace_back(
      Entity::Make(kAgentKind, x, y, 0, 0, kAgentRadius, kAgentRadius));
  agent.smart = true;
  agent.layer = 1;
  world_.grid.Reset(width, height, kEmptyKind);
  for (size_t kind = 0; kind < cell_looks_.size(); ++kind) {
    cell_looks_[kind] = {.image_kind = static_cast<int16_t>(kind), .theme = 0};
  }
}

void Game::StandardStep() {
  world_.shared_random = random_.Int(0, kSharedRandomRange);
  if (move_ != kNoAction) {
    last_move_ = move_;
  }
  const int32_t column = move_ / 3;
  const int32_t row = move_ % 3;
  world_.controls = {.horizontal = static_cast<float>(column - 1),
                     .vertical = static_cast<float>(row - 1),
                     .turn = 0};
  MapControls();
  Entity& agent = world_.agent();
  if (world_.whole_cell_motion) {
    agent.vx = world_.controls.horizontal;
    agent.vy = world_.controls.vertical;
  } else {
    UpdateAgentVelocity();
    agent.spin = kSpinDecay * agent.spin;
    agent.spin += kSpinPerTurn * world_.controls.turn;
  }
  MoveEntities();
  MeetAll(world_, *this);
  RemoveGone(world_);
  if (world_.IsOutside(world_.agent())) {
    outcome_.done = true;
  }
}

void Game::MoveEntities() {
  for (size_t i = world_.entities.size(); i-- > 0;) {
    Entity& entity = world_.entities[i];
    if (entity.smart) {
      MoveSmart(world_, *this, entity);
    }
    entity.Step();
  }
}

void Game::UpdateAgentVelocity() {
  Entity& agent = world_.agent();
  agent.vx = (1 - mix_) * agent.vx;
  agent.vx += (mix_ * top_speed_) * world_.controls.horizontal;
  agent.vx = static_cast<float>(kVelocityDecay * agent.vx);
  agent.vy = (1 - mix_) * agent.vy;
  agent.vy += (mix_ * top_speed_) * world_.controls.vertical;
  agent.vy = static_cast<float>(kVelocityDecay * agent.vy);
}

bool Game::Blocks(const Entity& /*mover*/, int kind, Axis /*axis*/) {
  return kind == kWallKind || kind == world_.out_of_bounds_kind;
}

bool Game::Reflects(const Entity& /*mover*/, int /*kind*/) { return false; }

void Game::OnAgentContact(Entity& /*other*/) {}

void Game::OnEntityContact(Entity& /*self*/, Entity& /*other*/) {}

void Game::OnCellContact(Entity& /*entity*/, int /*kind*/, int /*x*/, int /*y*/) {}

const ArtSlot* Game::FindSlot(int kind, int theme) const {
  for (const absl::Span<const ArtSlot> slots : {art_.slots, SharedArtSlots()}) {
    for (const ArtSlot& slot : slots) {
      if (slot.kind == kind && slot.theme == theme) {
        return &slot;
      }
    }
  }
  return nullptr;
}

int Game::ThemeCount(int kind) const {
  if (options_.use_generated_assets) {
    return 1;
  }
  const auto count = std::count_if(art_.slots.begin(), art_.slots.end(),
                                   [kind](const ArtSlot& slot) { return slot.kind == kind; });
  return std::max(1, static_cast<int>(count));
}

int Game::ShownTheme(int kind, int theme) const {
  const absl::Span<const int> kept = art_.kept_theme_kinds;
  const bool restricted =
      options_.restrict_themes && std::find(kept.begin(), kept.end(), kind) == kept.end();
  return restricted ? 0 : theme;
}

float Game::AspectRatio(int kind, int theme) const {
  if (options_.use_generated_assets) {
    return 1;
  }
  const ArtSlot* slot = FindSlot(kind, ShownTheme(kind, theme));
  return slot == nullptr ? 1 : static_cast<float>(slot->width_px * 1.0 / slot->height_px);
}

Camera Game::MakeCamera() const {
  if (center_agent_) {
    return {.center_x = world_.agent().x, .center_y = world_.agent().y, .cells = cells_in_view_};
  }
  const auto width = static_cast<float>(world_.grid.width());
  const auto height = static_cast<float>(world_.grid.height());
  return {.center_x = width / 2, .center_y = height / 2, .cells = std::max(width, height)};
}

int Game::ImageKindOf(const Entity& entity) const { return std::abs(entity.image_kind); }

void Game::StyleSprite(const Entity& /*entity*/, Sprite* /*sprite*/) const {}

void Game::AddOverlays(std::vector<Overlay>* /*overlays*/) const {}

void Game::FillScene(Scene* scene) const {
  scene->Clear();
  scene->camera = MakeCamera();
  scene->world_width = world_.grid.width();
  scene->world_height = world_.grid.height();
  scene->art_style = options_.use_monochrome_assets  ? ArtStyle::kMonochrome
                     : options_.use_generated_assets ? ArtStyle::kGenerated
                                                     : ArtStyle::kPictures;
  scene->background = {
      .shown = options_.use_backgrounds,
      .group = art_.background_group,
      .index = background_index_,
      .generated = options_.use_generated_assets ? &generated_background_ : nullptr,
      .offset = background_offset_,
      .tile_ratio = art_.background_tile_ratio,
      .scrolls = art_.background_scrolls,
      .scrolled_steps = art_.background_scrolls ? step_number_ : 0};
  AddSprites(-1, &scene->below_cells);
  FillCells(scene->camera, &scene->cells);
  AddSprites(0, &scene->above_cells);
  AddSprites(1, &scene->above_cells);
  scene->velocity = {.shown = options_.paint_vel_info && shows_velocity_,
                     .vx = world_.agent().vx,
                     .vy = world_.agent().vy,
                     .vx_max = top_speed_,
                     .vy_max = jump_speed_};
  AddOverlays(&scene->overlays);
}

void Game::FillLevelScene(Scene* scene) {
  const bool centers_agent = std::exchange(center_agent_, false);
  FillScene(scene);
  center_agent_ = centers_agent;
}

void Game::AddSprites(int layer, std::vector<Sprite>* sprites) const {
  for (const Entity& entity : world_.entities) {
    if (entity.layer != layer) {
      continue;
    }
    const int image_kind = ImageKindOf(entity);
    if (image_kind < 0) {
      continue;
    }
    Sprite& sprite = sprites->emplace_back();
    sprite.x = entity.x;
    sprite.y = entity.y;
    sprite.rx = entity.rx;
    sprite.ry = entity.ry;
    sprite.image_kind = static_cast<int16_t>(image_kind);
    sprite.theme = static_cast<int16_t>(ShownTheme(image_kind, entity.theme));
    sprite.mirrored = entity.mirrored;
    sprite.screen_coordinates = entity.screen_coordinates;
    sprite.rotation = entity.rotation;
    sprite.opacity = entity.opacity;
    StyleSprite(entity, &sprite);
  }
}

void Game::FillCells(const Camera& camera, CellLayer* cells) const {
  cells->grid = &world_.grid;
  cells->out_of_bounds_kind = world_.out_of_bounds_kind;
  cells->dots = cell_dots_;
  for (size_t kind = 0; kind < cell_looks_.size(); ++kind) {
    const CellAppearance& look = cell_looks_[kind];
    cells->looks[kind] = {look.image_kind,
                          static_cast<int16_t>(ShownTheme(look.image_kind, look.theme))};
  }
  if (center_agent_) {
    const auto reach = static_cast<float>(camera.cells / 2.0 + 1);
    cells->first_column = static_cast<int>(camera.center_x - reach);
    cells->last_column = static_cast<int>(camera.center_x + reach);
    cells->first_row = static_cast<int>(camera.center_y - reach);
    cells->last_row = static_cast<int>(camera.center_y + reach);
  } else {
    cells->first_column = 0;
    cells->last_column = world_.grid.width() - 1;
    cells->first_row = 0;
    cells->last_row = world_.grid.height() - 1;
  }
}

}  // namespace procgen
