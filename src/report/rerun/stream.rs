//! Messages in the order of the file. Their numbers are counted from a digest, so that the same content makes the same bytes.

use crate::error::{Error, Result};
use re_chunk::{Chunk, ChunkId, RowId};
use re_log_encoding::{Encodable, Encoder, MessageHeader, MessageKind};
use re_log_types::{
    BlueprintActivationCommand, EntityPath, LogMsg, SetStoreInfo, StoreId, StoreInfo, StoreKind,
    StoreSource, TimePoint, Timeline, external::re_tuid::Tuid,
};
use re_sdk_types::{AsComponents, archetypes::RecordingInfo, external::uuid::Uuid};

/// Who made a recording; the viewer keeps layouts by this name.
const APPLICATION: &str = "ballmark";

/// Messages, and the store that they go to.
pub(super) struct Stream {
    name: String,
    store: StoreId,
    messages: Vec<LogMsg>,
    last: u128,
}

/// When a row holds.
#[derive(Debug, Clone, Copy)]
pub(super) struct When {
    /// Steps from the start.
    pub step: usize,
    /// Way from the start, metres.
    pub travelled_m: f64,
}

impl From<When> for TimePoint {
    fn from(when: When) -> Self {
        let centimetres = (100.0 * when.travelled_m).round() as i64;
        TimePoint::default()
            .with(Timeline::new_sequence("step"), when.step as i64)
            .with(Timeline::new_sequence("travelled_cm"), centimetres)
    }
}

impl Stream {
    /// An empty one of a content with that digest (hexadecimal).
    pub fn new(digest: &str) -> Self {
        let name: String = digest.chars().take(16).collect();
        // The upper half of a number reads as a time where one is shown, so it stays positive.
        let first = u64::from_str_radix(&name, 16).unwrap_or(0) >> 2;
        Self {
            store: StoreId::new(StoreKind::Recording, APPLICATION, name.clone()),
            name,
            messages: Vec::new(),
            last: u128::from(first) << 64,
        }
    }

    /// What follows belongs to the recording of that title.
    pub fn begin_recording(&mut self, title: &str) -> Result<()> {
        self.begin(StoreKind::Recording);
        let info = RecordingInfo::new().with_name(title);
        self.still(EntityPath::properties(), &info)
    }

    /// What follows belongs to the layout.
    pub fn begin_blueprint(&mut self) {
        self.begin(StoreKind::Blueprint);
    }

    /// The layout is whole.
    pub fn end_blueprint(&mut self) {
        let command = BlueprintActivationCommand::make_active(self.store.clone());
        self.messages.push(command.into());
    }

    fn begin(&mut self, kind: StoreKind) {
        self.store = StoreId::new(kind, APPLICATION, self.name.clone());
        let source = StoreSource::Other(format!("ballmark {}", env!("CARGO_PKG_VERSION")));
        let info = StoreInfo::new(self.store.clone(), source);
        let row_id = Tuid::from_u128(self.number());
        self.messages.push(SetStoreInfo { row_id, info }.into());
    }

    /// A number that nothing else in the file has.
    fn number(&mut self) -> u128 {
        self.last += 1;
        self.last
    }

    /// The same as an identifier of a view or container.
    pub fn uuid(&mut self) -> Uuid {
        Uuid::from_u128(self.number())
    }

    /// What holds at all times.
    pub fn still(&mut self, path: EntityPath, content: &dyn AsComponents) -> Result<()> {
        self.rows(path, [(TimePoint::STATIC, content)])
    }

    /// Of one entity what holds from a time on.
    pub fn rows<'a>(
        &mut self,
        path: EntityPath,
        rows: impl IntoIterator<Item = (impl Into<TimePoint>, &'a dyn AsComponents)>,
    ) -> Result<()> {
        let mut chunk = Chunk::builder_with_id(ChunkId::from_u128(self.number()), path);
        for (when, content) in rows {
            let row = RowId::from_u128(self.number());
            chunk = chunk.with_archetype(row, when, content);
        }
        let chunk = chunk.build().map_err(refused)?;
        if !chunk.is_empty() {
            let message = chunk.to_arrow_msg().map_err(refused)?;
            self.messages
                .push(LogMsg::ArrowMsg(self.store.clone(), message));
        }
        Ok(())
    }

    /// The same with a value a step, of which some may have nothing to say.
    pub fn steps<T: AsComponents>(
        &mut self,
        path: EntityPath,
        steps: impl IntoIterator<Item = (When, Option<T>)>,
    ) -> Result<()> {
        let said = steps
            .into_iter()
            .filter_map(|(when, content)| Some((when, content?)));
        let said: Vec<(When, T)> = said.collect();
        let rows = said.iter().map(|(when, content)| (*when, content as _));
        self.rows(path, rows)
    }

    /// The file. It has no footer, which lists for servers where chunks lie: Rerun's columns of it come in an order of chance, and it is
    /// as large as two thirds of the rest. The viewer reads the file as a stream, and Rerun's own tools write a footer with what they merge.
    pub fn into_bytes(self) -> Result<Vec<u8>> {
        let mut encoder = Encoder::local().map_err(refused)?;
        encoder.do_not_emit_footer();
        for message in &self.messages {
            encoder.append(message).map_err(refused)?;
        }
        let mut bytes = encoder.into_inner().map_err(refused)?;
        let end = MessageHeader {
            kind: MessageKind::End,
            len: 0,
        };
        end.to_rrd_bytes(&mut bytes).map_err(refused)?;
        Ok(bytes)
    }
}

fn refused(e: impl std::fmt::Display) -> Error {
    Error::work(format!("recording for Rerun: {e}"))
}
