export default function Page() { return <h1>recording</h1>; }
