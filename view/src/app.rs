//! The window's life: events in, frames out.

use std::sync::Arc;
use std::time::{Duration, Instant};

use aam_renderer::{Renderer, Target};
use winit::application::ApplicationHandler;
use winit::dpi::PhysicalSize;
use winit::event::{StartCause, WindowEvent};
use winit::event_loop::{ActiveEventLoop, ControlFlow, EventLoop, EventLoopProxy};
use winit::window::{Window, WindowId};

use crate::graphics::{Graphics, Presented};
use crate::model::{Action, Model};
use crate::ui::{Asked, Panels, apply_theme};
use crate::{Options, ViewError};

/// How long a window without a picture waits before it tries again.
const HIDDEN: Duration = Duration::from_millis(250);

/// What other threads tell the window.
#[derive(Clone, Copy, Debug)]
enum Wake {
    /// Something was read.
    Loaded,
    /// A file changed.
    Changed,
}

/// Opens the window and stays until it is closed.
///
/// # Errors
/// There is no display, no device that draws to it, or it was lost.
pub fn run(options: &Options) -> Result<(), ViewError> {
    let event_loop = EventLoop::<Wake>::with_user_event()
        .build()
        .map_err(|error| ViewError::NoDisplay { reason: no_display(&error.to_string()) })?;
    let waker = |wake: Wake, proxy: EventLoopProxy<Wake>| {
        Arc::new(move || {
            // The window may be gone already.
            let _ = proxy.send_event(wake);
        }) as Arc<dyn Fn() + Send + Sync>
    };
    let loaded = waker(Wake::Loaded, event_loop.create_proxy());
    let changed = waker(Wake::Changed, event_loop.create_proxy());
    let mut app = App { model: Model::new(options, loaded, changed), size: options.size, shown: None, end: Ok(()) };
    event_loop.run_app(&mut app).map_err(|error| ViewError::Lost(error.to_string()))?;
    app.end
}

fn no_display(reason: &str) -> String {
    let unset = |name: &str| std::env::var_os(name).is_none_or(|value| value.is_empty());
    if cfg!(all(unix, not(target_os = "macos"))) && unset("DISPLAY") {
        "there is no display (DISPLAY is not set)".into()
    } else {
        reason.split(" (os error").next().unwrap_or(reason).to_owned()
    }
}

struct App {
    model: Model,
    size: [u32; 2],
    shown: Option<Shown>,
    end: Result<(), ViewError>,
}

/// All that exists only while there is a window.
struct Shown {
    window: Arc<Window>,
    graphics: Graphics,
    renderer: Renderer,
    egui: egui_winit::State,
    panels: Panels,
    picture: Picture,
    last_frame: Instant,
    title: String,
}

/// The texture that the scene is drawn to, for egui to show.
struct Picture {
    id: egui::TextureId,
    view: wgpu::TextureView,
    size: [u32; 2],
}

impl ApplicationHandler<Wake> for App {
    fn new_events(&mut self, _event_loop: &ActiveEventLoop, cause: StartCause) {
        if let (StartCause::ResumeTimeReached { .. }, Some(shown)) = (cause, &self.shown) {
            shown.window.request_redraw();
        }
    }

    fn resumed(&mut self, event_loop: &ActiveEventLoop) {
        if self.shown.is_some() {
            return;
        }
        match Shown::new(event_loop, self.size, &self.model) {
            Ok(shown) => {
                shown.window.request_redraw();
                self.shown = Some(shown);
            }
            Err(error) => self.end(event_loop, Err(error)),
        }
    }

    fn user_event(&mut self, _event_loop: &ActiveEventLoop, wake: Wake) {
        if matches!(wake, Wake::Changed) {
            self.model.reload();
        }
        if let Some(shown) = &self.shown {
            shown.window.request_redraw();
        }
    }

    fn window_event(&mut self, event_loop: &ActiveEventLoop, _window: WindowId, event: WindowEvent) {
        match event {
            WindowEvent::CloseRequested | WindowEvent::Destroyed => return self.end(event_loop, Ok(())),
            WindowEvent::RedrawRequested => return self.frame(event_loop),
            WindowEvent::DroppedFile(ref path) => self.model.open(path),
            _ => {}
        }
        let Some(shown) = &mut self.shown else { return };
        let response = shown.egui.on_window_event(&shown.window, &event);
        if response.repaint || matches!(event, WindowEvent::Resized(_) | WindowEvent::Occluded(false)) {
            shown.window.request_redraw();
        }
    }
}

impl App {
    fn end(&mut self, event_loop: &ActiveEventLoop, end: Result<(), ViewError>) {
        self.end = end;
        self.shown = None;
        event_loop.exit();
    }

    fn frame(&mut self, event_loop: &ActiveEventLoop) {
        let Some(shown) = &mut self.shown else { return };
        if let Some(reason) = shown.graphics.gpu.lost() {
            return self.end(event_loop, Err(ViewError::Lost(reason)));
        }
        self.model.take_finished();
        match shown.frame(&mut self.model) {
            Ok(Next::Quit) => self.end(event_loop, Ok(())),
            Ok(Next::At(delay)) => match Instant::now().checked_add(delay) {
                _ if delay.is_zero() => shown.window.request_redraw(),
                Some(time) => event_loop.set_control_flow(ControlFlow::WaitUntil(time)),
                None => event_loop.set_control_flow(ControlFlow::Wait),
            },
            Err(reason) => self.end(event_loop, Err(ViewError::Lost(reason))),
        }
    }
}

/// What comes after a frame.
enum Next {
    /// Another frame, after this long.
    At(Duration),
    Quit,
}

impl Shown {
    fn new(event_loop: &ActiveEventLoop, [width, height]: [u32; 2], model: &Model) -> Result<Self, ViewError> {
        let title = model.title();
        let attributes = Window::default_attributes()
            .with_title(&title)
            .with_inner_size(PhysicalSize::new(width.max(1), height.max(1)))
            .with_min_inner_size(PhysicalSize::new(320, 240));
        let window = event_loop
            .create_window(attributes)
            .map_err(|error| ViewError::NoDisplay { reason: no_display(&error.to_string()) })?;
        let window = Arc::new(window);
        let mut graphics = Graphics::new(&window, event_loop.owned_display_handle())?;
        let renderer = Renderer::new(graphics.gpu.clone());
        let context = egui::Context::default();
        apply_theme(&context);
        let largest = usize::try_from(graphics.max_texture_side()).ok();
        let egui = egui_winit::State::new(context, egui::ViewportId::ROOT, &*window, None, None, largest);
        let view = graphics.picture_view([1, 1]);
        let id = graphics.painter.register_native_texture(graphics.gpu.device(), &view, wgpu::FilterMode::Nearest);
        let picture = Picture { id, view, size: [1, 1] };
        Ok(Self {
            window,
            graphics,
            renderer,
            egui,
            panels: Panels::default(),
            picture,
            last_frame: Instant::now(),
            title,
        })
    }

    fn frame(&mut self, model: &mut Model) -> Result<Next, String> {
        let playing = model.advance(std::mem::replace(&mut self.last_frame, Instant::now()).elapsed());
        let title = model.title();
        if title != self.title {
            self.window.set_title(&title);
            self.title = title;
        }
        let input = self.egui.take_egui_input(&self.window);
        let context = self.egui.egui_ctx().clone();
        let mut asked = Asked::default();
        let mut output = context.run_ui(input, |ui| asked = self.panels.show(ui, model, self.picture.id));
        for action in &asked.actions {
            if self.act(*action, model) {
                output.textures_delta.clear();
                return Ok(Next::Quit);
            }
        }
        let pixels_per_point = output.pixels_per_point;
        self.draw_picture(model, &asked, pixels_per_point);
        self.egui.handle_platform_output(&self.window, output.platform_output);
        let primitives = context.tessellate(output.shapes, pixels_per_point);
        let size = self.window.inner_size();
        let presented =
            self.graphics.paint(&self.window, size, &primitives, output.textures_delta, pixels_per_point)?;
        let wanted = output.viewport_output.get(&egui::ViewportId::ROOT).map_or(Duration::MAX, |out| out.repaint_delay);
        Ok(Next::At(match presented {
            Presented::Again => Duration::ZERO,
            Presented::Hidden => HIDDEN,
            // What an action changed is to be seen.
            Presented::Yes if playing || model.stale || !asked.actions.is_empty() => Duration::ZERO,
            Presented::Yes => wanted,
        }))
    }

    /// Does what was asked for; true if the window is to close.
    fn act(&mut self, action: Action, model: &mut Model) -> bool {
        match action {
            Action::Panels => self.panels.toggle(),
            Action::Help => self.panels.help = !self.panels.help,
            Action::Quit if self.panels.help => self.panels.help = false,
            Action::Quit => return model.may_quit(),
            Action::Screenshot => {
                let [width, height] = self.picture.size;
                model.screenshot(&mut self.renderer, width, height);
            }
            other => model.act(other),
        }
        false
    }

    /// Brings the scene's texture up to date.
    fn draw_picture(&mut self, model: &mut Model, asked: &Asked, pixels_per_point: f32) {
        let Some(rect) = asked.picture else { return };
        let largest = self.graphics.max_texture_side();
        let side = |points: f32| ((points * pixels_per_point).round().max(0.0) as u32).min(largest);
        let size = [side(rect.width()), side(rect.height())];
        if size[0] == 0 || size[1] == 0 {
            return;
        }
        if size != self.picture.size {
            self.picture.view = self.graphics.picture_view(size);
            self.picture.size = size;
            self.graphics.painter.update_egui_texture_from_wgpu_texture(
                self.graphics.gpu.device(),
                &self.picture.view,
                wgpu::FilterMode::Nearest,
                self.picture.id,
            );
            model.stale = true;
        }
        if model.stale {
            model.draw(&mut self.renderer, &Target::new(&self.picture.view), size[0], size[1]);
        }
    }
}
